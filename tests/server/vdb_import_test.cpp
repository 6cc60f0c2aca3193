// OpenVDB files that the library itself wrote, imported by a process of its own.
#include <openvdb/openvdb.h>

#include "scene_import_fixture.h"
#include "support/sanitized.h"

namespace probebake {
namespace {

using test::SceneImportTest;

TEST_F(SceneImportTest, DamagedVdbFilesEndWithAReason) {
    openvdb::initialize();
    const auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setName("density");
    for (int x = 0; x < 16; ++x) {
        for (int y = 0; y < 16; ++y) {
            for (int z = 0; z < 16; ++z) {
                grid->tree().setValue({x, y, z}, static_cast<float>((x * y + z) % 17) / 17.0f);
            }
        }
    }
    openvdb::io::File(path("cloud.vdb").string()).write({grid});
    test::write_text(path("cloud.json"),
                     R"({"type": "generator", "generator": "box", "size": 16, "media": [)"
                     R"({"type": "vdb", "file": "cloud.vdb", "grid": "density",)"
                     R"( "scattering_per_m": [1, 1, 1]}]})");
    EXPECT_EQ(refusal(read_scene_file(path("cloud.json")), process()), "");
    if (test::thread_sanitized()) {
        GTEST_SKIP() << "the sanitizer reports allocations of damaged sizes, which would throw";
    }
    expect_damage_is_told("cloud.json", "cloud.vdb", test::read_text(path("cloud.vdb")));
}

}  // namespace
}  // namespace probebake
