// An equirectangular sky from its file to the baked cubemap.
#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "bake/state_light.h"
#include "image/exr.h"
#include "image/exr_file.h"
#include "io/file.h"
#include "light/sky_file.h"
#include "support/data.h"

namespace probebake {
namespace {

class EnvironmentTest : public testing::Test {
  protected:
    void SetUp() override {
        const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        scene_.folder = std::filesystem::path(testing::TempDir()) / ("probebake-sky-" + test);
        std::filesystem::create_directories(scene_.folder);
    }
    void TearDown() override { std::filesystem::remove_all(scene_.folder); }

    /// The cubemap of one probe under the picture, as it is read back from the product.
    Cubemap bake(const std::string& file) const {
        Json request = test::small_request(1);
        request["lighting_states"] = Json::array(
            {{{"id", "sky"},
              {"sky", {{"type", "equirect"}, {"file", file}, {"scale", kScale}, {"rays", 32}}}}});
        const JobSpec job = read_job(request);
        const Plan plan = make_plan(scene_, job);
        const ReadyState state = light_state(scene_, job, 0, cancel_);
        EXPECT_EQ(state.light->sky_sha256.size(), 64u);
        const Pilot pilot = run_pilot(scene_, job, plan, state, cancel_);
        const ProbeResult result = bake_probe(scene_, job, pilot, {}, cancel_);
        EXPECT_EQ(result.files.at(0).name, "cube.exr");
        return decode_cubemap(result.files.at(0).bytes, "cube.exr").cubemap;
    }
    /// A pixel that sees the sky shows the picture there; one that sees a voxel shows light of it.
    void expect_sky_and_light(const Cubemap& cube, const std::string& file) const {
        const Sky sky(SkyPicture{read_sky_file(scene_.folder / file).image, kScale, 0.0});
        const int n = cube.face_size();
        int misses = 0;
        int lit = 0;
        for (const CubeFace face : kCubeFaces) {
            const View view = cube_face_view(face, n, test::kSmallWorldProbe);
            for (int y = 1; y + 1 < n; ++y) {
                for (int x = 1; x + 1 < n; ++x) {
                    bool all_miss = true;
                    bool all_hit = true;
                    double lowest = 1e9;
                    double highest = 0.0;
                    // A little beyond the footprint, and finer than that margin: what the rays
                    // between these could still hit.
                    for (int i = 0; i < kGrid * kGrid; ++i) {
                        const int row = i / kGrid;
                        const Ray ray = pixel_ray(view, x - 0.6 + 1.2 * (i % kGrid + 0.5) / kGrid,
                                                  y - 0.6 + 1.2 * (row + 0.5) / kGrid)
                                            .ray;
                        const bool hit = static_cast<bool>(trace(scene_.tree, ray));
                        all_miss = all_miss && !hit;
                        all_hit = all_hit && hit;
                        const double g = double{sky.radiance(ray.direction).g};
                        lowest = std::min(lowest, g);
                        highest = std::max(highest, g);
                    }
                    const double got = double{cube.at({face, x, y}).g};
                    if (all_miss) {
                        ++misses;
                        // HALF rounds by 2^-11.
                        EXPECT_GE(got, lowest * 0.999) << file;
                        EXPECT_LE(got, highest * 1.001) << file;
                    }
                    if (all_hit && got > 0.0) ++lit;
                }
            }
        }
        EXPECT_GT(misses, 30) << file;
        EXPECT_GT(lit, 100) << file;
    }

    static constexpr int kGrid = 24;
    static constexpr double kScale = 20.0;
    Scene scene_ = test::small_scene();
    CancelToken cancel_;
};

std::vector<std::byte> exr_of(const Image& image) {
    const auto* first = reinterpret_cast<const std::byte*>(image.pixels().data());
    const ExrChannel<const std::byte> channels[] = {
        {"R", Imf::FLOAT, first, sizeof(Rgb)},
        {"G", Imf::FLOAT, first + sizeof(float), sizeof(Rgb)},
        {"B", Imf::FLOAT, first + 2 * sizeof(float), sizeof(Rgb)}};
    return encode_exr(Imf::Header(image.width(), image.height()), channels);
}

/// The environment of configs/jobs, as Radiance has it and as OpenEXR.
TEST_F(EnvironmentTest, TheSameSkyInBothFormatsGivesTheSameCubemap) {
    const std::filesystem::path own = PROBEBAKE_SOURCE_DIR "/configs/scenes/dusk.hdr";
    std::filesystem::copy_file(own, scene_.folder / "dusk.hdr");
    write_file_atomically(scene_.folder / "dusk.exr", exr_of(*read_sky_file(own).image));
    const Cubemap from_hdr = bake("dusk.hdr");
    const Cubemap from_exr = bake("dusk.exr");
    const auto a = from_hdr.image().pixels();
    const auto b = from_exr.image().pixels();
    EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
    expect_sky_and_light(from_hdr, "dusk.hdr");
}

/// A sunrise over the sea (MANIFEST: hdr).
TEST_F(EnvironmentTest, ARealSkyIsSeenAndLights) {
    for (const std::string name : {"blouberg_sunrise_2_1k.hdr", "blouberg_sunrise_2_1k.exr"}) {
        const auto path = test::data_file("hdr/" + name);
        if (!path) GTEST_SKIP() << "no hdr/ in PROBEBAKE_DATA";
        std::filesystem::copy_file(*path, scene_.folder / name);
        expect_sky_and_light(bake(name), name);
    }
}

}  // namespace
}  // namespace probebake
