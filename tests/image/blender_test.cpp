// What Blender sees of a latlong map as the light of its world.
#include <gtest/gtest.h>

#include "image/cubemaps.h"
#include "image/exr.h"
#include "image/layouts.h"
#include "image/rgb_file.h"
#include "image/tools.h"
#include "io/file.h"

namespace probebake {
namespace {

// Blender's world is Z up: its (x, y, z) is our (z, x, y). A camera of 1° along each axis, and
// between them, must see the colour of its direction; a map mirrored or turned shows another.
TEST(Blender, SeesTheLatlongWhereItBelongs) {
    if (!test::has_tool("blender")) GTEST_SKIP() << "blender is not installed";
    const test::TemporaryFolder folder;
    const std::string latlong = (folder / "latlong.exr").string();
    write_file_atomically(
        latlong,
        encode_layout(latlong_of(test::direction_cubemap(64)), ExrLayout::kLatlong, {}).bytes);
    const auto run = test::run_tool(
        "blender --background --factory-startup --python-exit-code 1 --python " PROBEBAKE_SOURCE_DIR
        "/tests/image/blender_world.py -- " +
        latlong + " " + (folder / "seen").string());
    ASSERT_EQ(run.status, 0) << run.text;
    const std::array directions = {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0),
                                   Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 2, 3), Vec3(-2, 1, 1)};
    for (size_t i = 0; i < directions.size(); ++i) {
        const Vec3 in_blender = glm::normalize(directions[i]);
        const Vec3 ours(in_blender.y, in_blender.z, in_blender.x);
        const Image picture =
            test::read_rgb_file((folder / ("seen" + std::to_string(i) + ".exr")).string());
        const Vec3 seen(picture.at(picture.width() / 2, picture.height() / 2));
        EXPECT_LT(glm::length(seen - (0.5 + 0.5 * ours)), 0.03) << i;
    }
}

}  // namespace
}  // namespace probebake
