#include "scene/media_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "io/file.h"
#include "scene/scene_library.h"
#include "scene/vdb/vdb_file.h"

namespace probebake {
namespace {

class MediaFileTest : public testing::Test {
  protected:
    void SetUp() override {
        const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = std::filesystem::path(testing::TempDir()) / ("probebake-media-" + test);
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    SceneFile read(const std::string& media) const {
        const std::string text =
            R"({"type": "generator", "generator": "single", "size": 16, "media": )" + media + "}";
        write_file_atomically(folder_ / "scene.json", text);
        return read_scene_file(folder_ / "scene.json");
    }
    /// JSON pointers of all that is wrong.
    std::string refused(const std::string& media) const {
        std::string pointers;
        try {
            read(media);
        } catch (const SpecError& error) {
            for (const SpecIssue& issue : error.issues()) {
                pointers += (pointers.empty() ? "" : " ") + issue.pointer;
            }
        }
        return pointers;
    }

    std::filesystem::path folder_;
};

TEST_F(MediaFileTest, MediaOfAllTypesAreRead) {
    const Scene scene = load_scene(read(R"([
        {"type": "homogeneous", "name": "smoke", "absorption_per_m": [0.1, 0.2, 0.3], "g": -0.2,
         "box_m": {"low": [0, 0, 0], "high": [1, 2, 3]}, "emission_w_m2_sr": [1, 0, 0]},
        {"type": "fog", "scattering_per_m": [0.01, 0.01, 0.02], "base_m": 5, "scale_height_m": 20},
        {"type": "cumulus", "scattering_per_m": [1, 1, 1], "g": 0.8, "size": 32, "width_m": 64,
         "origin_m": [100, 10, -5], "rotation_deg": 90}])"));
    const std::vector<Medium>& media = scene.media.all();
    ASSERT_EQ(media.size(), 3u);
    EXPECT_EQ(media[0].spec.name, "smoke");
    EXPECT_EQ(media[0].unit.absorption[2], double{0.3f});
    EXPECT_EQ(media[0].spec.g, -0.2);
    EXPECT_EQ(media[0].density(Vec3(0.5)), 1.0);
    EXPECT_EQ(media[0].density(Vec3(1.5)), 0.0);
    EXPECT_NEAR(media[1].density(Vec3(0, 25, 0)), std::exp(-1.0), 1e-12);
    // 2 m per cell; +Z of the grid points along +X, +X along −Z.
    const DensityGrid grid = make_cumulus({.size = 32});
    double most = 0.0;
    for (int i = 8; i < 24; ++i) {
        const Vec3 index(i, 13, 15);
        const Vec3 world = Vec3(100, 10, -5) + 2.0 * Vec3(index.z, index.y, -index.x);
        EXPECT_NEAR(media[2].density(world), grid.sample(index), 1e-6);
        most = std::max(most, grid.sample(index));
    }
    EXPECT_GT(most, 0.3);
    EXPECT_FALSE(is_finite(extent_of(scene.media).low));  // fog
    EXPECT_GT(scene.memory_bytes(), scene.tree.memory_bytes());
}

TEST_F(MediaFileTest, EveryMistakeHasItsPointer) {
    EXPECT_EQ(refused("[]"), "");
    EXPECT_EQ(refused("{}"), "/media");
    EXPECT_EQ(refused(R"([{"type": "steam", "scattering_per_m": [1, 1, 1]}])"), "/media/0/type");
    EXPECT_EQ(refused(R"([{"type": "homogeneous"}])"), "/media/0/scattering_per_m");
    EXPECT_EQ(refused(R"([{"type": "homogeneous", "scattering_per_m": [1, -1, 1]}])"),
              "/media/0/scattering_per_m/1");
    EXPECT_EQ(refused(R"([{"type": "homogeneous", "scattering_per_m": [1, 1, 1], "g": 1}])"),
              "/media/0/g");
    EXPECT_EQ(refused(R"([{"type": "homogeneous", "scattering_per_m": [1, 1, 1],
                           "emission_w_m2_sr": [0, 1, 0]}])"),
              "/media/0/emission_w_m2_sr/1");
    EXPECT_EQ(refused(R"([{"type": "homogeneous", "scattering_per_m": [1, 1, 1],
                           "box_m": {"low": [0, 0, 0], "high": [1, 0, 1]}}])"),
              "/media/0/box_m/high/1");
    EXPECT_EQ(refused(R"([{"type": "fog", "scattering_per_m": [1, 1, 1]}])"),
              "/media/0/scale_height_m");
    EXPECT_EQ(refused(R"([{"type": "fog", "scattering_per_m": [1, 1, 1], "scale_height_m": 1,
                           "heigth": 2}])"),
              "/media/0/heigth");
    EXPECT_EQ(refused(R"([{"type": "vdb", "scattering_per_m": [1, 1, 1], "file": "../x.vdb"}])"),
              "/media/0/file");
    EXPECT_EQ(refused(R"([{"type": "cumulus", "scattering_per_m": [1, 1, 1], "size": 8,
                           "width_m": 10}])"),
              "/media/0/size");
    std::string nine;
    for (int i = 0; i < 9; ++i) {
        nine += (i > 0 ? "," : "") +
                std::string(R"({"type": "homogeneous", "scattering_per_m": [1, 1, 1]})");
    }
    EXPECT_EQ(refused("[" + nine + "]"), "/media");
}

TEST_F(MediaFileTest, AMissingGridFileIsAnErrorWithItsName) {
    const SceneFile file =
        read(R"([{"type": "vdb", "scattering_per_m": [1, 1, 1], "file": "none.vdb"}])");
    try {
        load_scene(file);
        FAIL();
    } catch (const IoError& error) {
        EXPECT_NE(std::string(error.what()).find("none.vdb"), std::string::npos);
    }
}

TEST_F(MediaFileTest, BuildsWithoutOpenVdbSaySo) {
    if (reads_vdb()) GTEST_SKIP() << "this build reads OpenVDB files";
    write_file_atomically(folder_ / "cloud.vdb", "anything");
    const SceneFile file =
        read(R"([{"type": "vdb", "scattering_per_m": [1, 1, 1], "file": "cloud.vdb"}])");
    try {
        load_scene(file);
        FAIL();
    } catch (const IoError& error) {
        EXPECT_EQ(std::string(error.what()), "cloud.vdb: this build reads no OpenVDB files");
    }
}

}  // namespace
}  // namespace probebake
