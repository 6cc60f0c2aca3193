#include <ImfChannelList.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "image/exr_file.h"
#include "io/file.h"
#include "io/io_error.h"
#include "io/spec_error.h"
#include "math/random.h"
#include "scene/heightmap/heightmap_import.h"
#include "scene/png_writer.h"
#include "scene/scene_library.h"
#include "support/data.h"
#include "voxels/trace.h"

namespace probebake {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

std::string problem_of(const std::string& png) {
    try {
        read_grey_png(bytes_of(png), "h.png");
    } catch (const IoError& error) {
        return error.what();
    }
    return "none";
}

VoxelTree tree_of(const GreyPicture& heights, const HeightmapParams& params = {}) {
    return VoxelTree::build(import_heightmap(heights, std::nullopt, params, "h.png"));
}

TEST(Heightmap, ColumnsAreAsHighAsTheyShould) {
    const GreyPicture heights =
        read_grey_png(bytes_of(test::grey_png(3, {0, 100, 7, 9, 65535, 4})), "h.png");
    EXPECT_EQ(heights.width_px, 3);
    EXPECT_EQ(heights.height_px, 2);
    // 0.1 m per count, voxels of 0.25 m: 100 counts are 40 voxels, 7 are 2.8, 9 are 3.6.
    HeightmapParams params{.height_scale_m = 0.1, .voxel_size_m = 0.25};
    const VoxelTree tree = tree_of(heights, params);
    const auto top = [&](int x, int z) {
        const Hit hit = trace(tree, {Vec3(x + 0.5, 1e5, z + 0.5), Vec3(0, -1, 0)});
        return hit ? hit.corner.y + 1 : 0;
    };
    EXPECT_EQ(top(0, 0), 1);  // at least one voxel
    EXPECT_EQ(top(1, 0), 40);
    EXPECT_EQ(top(2, 0), 3);
    EXPECT_EQ(top(0, 1), 4);
    EXPECT_EQ(top(1, 1), 26214);
    EXPECT_EQ(top(2, 1), 2);
    params.height_scale_m = 0.3;  // 78,642 voxels
    EXPECT_THROW(tree_of(heights, params), IoError);
    params = {.height_scale_m = 0.1, .voxel_size_m = 0.25, .max_voxels = 1000};
    EXPECT_THROW(tree_of(heights, params), IoError);
}

TEST(Heightmap, NoRayPassesBetweenColumns) {
    GreyPicture heights{.width_px = 64, .height_px = 64, .values = {}};
    for (uint32_t i = 0; i < 64 * 64; ++i) {
        heights.values.push_back(static_cast<uint16_t>(1 + mix64(i) % 40));
    }
    const VoxelTree tree = tree_of(heights);
    RandomStream random(7);
    for (int i = 0; i < 20000; ++i) {
        // From above the middle in all downward directions that end on the terrain.
        const Vec3 origin(32.1 + random.uniform(), 60.3, 31.7 + random.uniform());
        const Vec3 target(1.0 + 62.0 * random.uniform(), 0.5, 1.0 + 62.0 * random.uniform());
        const Hit hit = trace(tree, {origin, glm::normalize(target - origin)});
        ASSERT_TRUE(hit) << i;
        ASSERT_LE(hit.t, glm::length(target - origin)) << i;
        const Vec3 met = origin + hit.t * glm::normalize(target - origin);
        const auto column = static_cast<size_t>(hit.corner.z * 64 + hit.corner.x);
        // The surface itself, not something inside of it.
        ASSERT_LE(met.y, heights.values[column] + 1e-9);
        ASSERT_LT(hit.corner.y, heights.values[column]);
    }
    // Nothing that nobody can see: far fewer voxels than full columns would have.
    uint64_t full = 0;
    for (const uint16_t h : heights.values) full += h;
    EXPECT_LT(tree.voxel_count(), full);
}

TEST(Heightmap, ColoursAreLinearAndOfTheSameSize) {
    const GreyPicture heights{.width_px = 2, .height_px = 1, .values = {1, 1}};
    const ColorPicture colors = read_color_picture(
        bytes_of(test::rgb_png(2, std::string("\xFF\x80\x00\x00\x00\xFF", 6))), "c.png");
    const VoxelTree tree = VoxelTree::build(import_heightmap(heights, colors, {}, "h.png"));
    ASSERT_EQ(tree.voxel_count(), 2u);
    const Rgb first = tree.colors().albedo[{ColorIndex::Array::kVoxels, 0}];
    EXPECT_NEAR(first.r, 1.0f, 0.002f);
    EXPECT_NEAR(first.g, 0.2159f, 0.002f);  // sRGB 128
    EXPECT_EQ(first.b, 0.0f);
    const ColorPicture other{.width_px = 1, .height_px = 2, .values = colors.values};
    EXPECT_THROW(import_heightmap(heights, other, {}, "h.png"), IoError);
    const VoxelTree grey = tree_of(heights);
    EXPECT_NEAR((grey.colors().albedo[{ColorIndex::Array::kVoxels, 1}].g), 0.5f, 0.002f);
}

TEST(Heightmap, OtherPicturesAreRefused) {
    EXPECT_EQ(problem_of(test::grey_png(1, {5})), "none");
    const std::pair<std::string, std::string> cases[] = {
        {"", "h.png: offset 0: is neither a PNG nor a JPEG"},
        {"GIF89a", "h.png: offset 0: is neither a PNG nor a JPEG"},
        {test::rgb_png(1, "abc"), "h.png: has 3 channels of 8 bits, expected"},
        {test::png_file({.bits = 8, .samples = "a"}), "h.png: has 1 channels of 8 bits"},
        {test::grey_png(1, {5}) + "x", "h.png: offset 71: bytes follow"},
        {test::png_file({.width_px = 20000, .samples = "ab"}), "h.png: cannot be decoded"},
        {"\xFF\xD8\xFF\xE0 cut off", "h.png: offset 12: the JPEG has no end marker"},
        {"\xFF\xD8\xFF\xE0 rubbish\xFF\xD9", "h.png: cannot be decoded"},
    };
    for (const auto& [file, expected] : cases) {
        EXPECT_EQ(problem_of(file).substr(0, expected.size()), expected);
    }
}

TEST(Heightmap, EveryDamagedByteIsNoticed) {
    const std::string whole = test::grey_png(4, std::vector<uint16_t>(16, 300));
    ASSERT_EQ(problem_of(whole), "none");
    for (size_t i = 0; i < whole.size(); ++i) {
        std::string cut = whole.substr(0, i);
        EXPECT_NE(problem_of(cut), "none") << i;
        for (const int flip : {1, 0x80, 0xFF}) {
            std::string damaged = whole;
            damaged[i] = static_cast<char>(damaged[i] ^ flip);
            EXPECT_NE(problem_of(damaged), "none") << i;
        }
    }
}

class HeightmapSceneTest : public testing::Test {
  protected:
    void SetUp() override {
        const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = std::filesystem::path(testing::TempDir()) / ("probebake-heightmap-" + test);
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    SceneFile scene(const std::string& fields) const {
        write_file_atomically(folder_ / "hill.json", R"({"type": "heightmap", )" + fields + "}");
        return read_scene_file(folder_ / "hill.json");
    }
    std::filesystem::path folder_;
};

TEST_F(HeightmapSceneTest, IsLoadedAndHashed) {
    write_file_atomically(folder_ / "h.png", test::grey_png(2, {4, 8, 4, 8}));
    write_file_atomically(folder_ / "c.png", test::rgb_png(2, "abcabcabcabc"));
    const std::string fields = R"("file": "h.png", "height_scale_m": 0.5, "voxel_size_m": 2)";
    const Scene grey = load_scene(scene(fields));
    const Scene colored = load_scene(scene(fields + R"(, "color_file": "c.png")"));
    EXPECT_EQ(grey.tree.voxel_count(), 2u + 2u * 2u);
    EXPECT_EQ(grey.voxel_size_m, 2.0);
    EXPECT_NE(grey.sha256, colored.sha256);
    write_file_atomically(folder_ / "c.png", test::rgb_png(2, "abcabcabcabd"));
    EXPECT_NE(content_sha256(scene(fields + R"(, "color_file": "c.png")")), colored.sha256);

    EXPECT_THROW(scene(R"("file": "h.png", "voxel_size_m": 2)"), SpecError);
    EXPECT_THROW(scene(R"("file": "h.png", "height_scale_m": 0.5)"), SpecError);
    EXPECT_THROW(scene(R"("file": "../h.png", "height_scale_m": 1, "voxel_size_m": 2)"), SpecError);
    EXPECT_THROW(scene(fields + R"(, "color_file": "/c.png")"), SpecError);
    EXPECT_THROW(scene(fields + R"(, "size": 4)"), SpecError);
    EXPECT_THROW(load_scene(scene(fields + R"(, "color_file": "none.png")")), IoError);
}

/// One picture of floats, every channel of the same values.
std::string exr_text(int width_px, std::vector<float> values,
                     const std::vector<const char*>& channels) {
    const auto height_px = static_cast<int>(values.size()) / width_px;
    Imf::Header header(width_px, height_px);
    std::vector<ExrChannel<const std::byte>> all;
    for (const char* name : channels) {
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        all.push_back(
            {name, Imf::FLOAT, reinterpret_cast<const std::byte*>(values.data()), sizeof(float)});
    }
    const std::vector<std::byte> bytes = encode_exr(header, all);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST_F(HeightmapSceneTest, HeightsInMetres) {
    // Half a metre per voxel, from 2 m below 0 to 1.6 m above it.
    write_file_atomically(folder_ / "h.exr", exr_text(2, {-2.0f, 1.6f, 0.0f, 0.3f}, {"Y"}));
    const std::string fields = R"("file": "h.exr", "voxel_size_m": 0.5)";
    const Scene loaded = load_scene(scene(fields));
    const auto top_m = [&](double x, double z) {
        const Ray ray{loaded.to_voxels({x, 100.0, z}), Vec3(0, -1, 0)};
        return 100.0 - trace(loaded.tree, ray).t * loaded.voxel_size_m;
    };
    EXPECT_NEAR(top_m(0.25, 0.25), -2.0, 1e-9);
    EXPECT_NEAR(top_m(0.75, 0.25), 1.5, 1e-9);
    EXPECT_NEAR(top_m(0.25, 0.75), 0.0, 1e-9);
    EXPECT_NEAR(top_m(0.75, 0.75), 0.5, 1e-9);
    EXPECT_EQ(loaded.corner_m, Vec3(0.0, -2.5, 0.0));
    const Scene doubled = load_scene(scene(fields + R"(, "height_scale_m": 2)"));
    EXPECT_EQ(doubled.corner_m, Vec3(0.0, -4.5, 0.0));
    const auto refused = [&](const std::string& text) {
        write_file_atomically(folder_ / "h.exr", text);
        EXPECT_THROW(load_scene(scene(fields)), IoError);
    };
    refused(exr_text(2, {0.0f, 1.0f}, {"R", "G"}));
    refused(exr_text(2, {0.0f, std::numeric_limits<float>::quiet_NaN()}, {"Y"}));
    refused(exr_text(2, {0.0f, 1e30f}, {"Y"}));
    refused(exr_text(2, {-1e30f, -1e30f}, {"Y"}));
    refused(test::grey_png(2, {4, 8, 4, 8}));
}

TEST(HeightmapData, TheLidarTerrain) {
    const auto heights = test::data_file("terrain/autzen_2048_dsm_u16.png");
    const auto colors = test::data_file("terrain/autzen_2048_rgb.jpg");
    if (!heights || !colors) GTEST_SKIP() << "no terrain in PROBEBAKE_DATA";
    SceneFile file;
    file.name = "autzen";
    file.voxel_size_m = 0.25;
    file.heightmap = HeightmapFiles{*heights, *colors, 1.0 / 256.0};
    const Scene scene = load_scene(file);
    IVec3 highest(-1);
    scene.tree.for_each_voxel([&](const IVec3& p) { highest = glm::max(highest, p); });
    EXPECT_EQ(highest, IVec3(2047, 141, 2047));  // 2048 × 142 × 2048 voxels of 25 cm
    EXPECT_EQ(scene.tree.depth(), 11);
    EXPECT_GE(scene.tree.voxel_count(), 2048u * 2048u);
    // Vegetation, roofs and streets of Oregon: neither black nor white.
    const Rgb mean = scene.tree.colors().albedo[{ColorIndex::Array::kNodes, 0}];
    for (int c = 0; c < 3; ++c) {
        EXPECT_GT(mean[c], 0.02f);
        EXPECT_LT(mean[c], 0.6f);
    }
    std::printf("autzen: %llu voxels, %.3f nodes per voxel\n",
                static_cast<unsigned long long>(scene.tree.voxel_count()),
                static_cast<double>(scene.tree.octree_node_count()) /
                    static_cast<double>(scene.tree.voxel_count()));
}

}  // namespace
}  // namespace probebake
