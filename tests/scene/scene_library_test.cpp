#include "scene/scene_library.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "io/file.h"
#include "io/spec_error.h"
#include "scene/vox/vox_import.h"
#include "scene/vox_seeds.h"

namespace probebake {
namespace {

class SceneLibraryTest : public testing::Test {
  protected:
    void SetUp() override {
        const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = std::filesystem::path(testing::TempDir()) / ("probebake-scenes-" + test);
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    void write(const std::string& name, const std::string& text) const {
        write_file_atomically(folder_ / name, text);
    }
    /// What is wrong with a scene file of this text; "none" where nothing is.
    std::string problem_of(const std::string& text) const {
        write("broken.json", text);
        try {
            read_scene_file(folder_ / "broken.json");
        } catch (const SpecError& error) {
            return error.what();
        }
        return "none";
    }

    std::filesystem::path folder_;
};

constexpr const char* kSphere =
    R"({"type": "generator", "generator": "sphere", "size": 32, "voxel_size_m": 0.5,
        "origin_m": [1, 2, 3], "description": "a ball"})";

TEST_F(SceneLibraryTest, ListsAndFindsByNameOnly) {
    write("ball.json", kSphere);
    write("other.json", kSphere);
    write("Not-A-Name.json", kSphere);
    write("notes.txt", "nothing");
    const SceneLibrary library(folder_);
    EXPECT_EQ(library.names(), (std::vector<std::string>{"ball", "other"}));
    ASSERT_TRUE(library.find("ball").has_value());
    EXPECT_EQ(library.find("ball")->description, "a ball");
    for (const char* name : {"missing", "../ball", "ball.json", "", "/etc/passwd", "Not-A-Name"}) {
        EXPECT_FALSE(library.find(name).has_value()) << name;
    }
    EXPECT_THROW(SceneLibrary(folder_ / "nowhere"), IoError);
}

TEST_F(SceneLibraryTest, NothingLeadsOutOfItsFolder) {
    namespace fs = std::filesystem;
    const fs::path outside = folder_.string() + "-outside";
    fs::create_directories(outside);
    write_file_atomically(outside / "ball.json", std::string(kSphere));
    write_file_atomically(outside / "m.vox", std::string("VOX "));
    fs::create_symlink(outside / "ball.json", folder_ / "ball.json");
    fs::create_symlink(outside / "m.vox", folder_ / "m.vox");
    write("m.json", R"({"type": "vox", "file": "m.vox", "voxel_size_m": 1})");
    EXPECT_THROW(SceneLibrary(folder_).find("ball"), IoError);
    EXPECT_THROW(content_sha256(read_scene_file(folder_ / "m.json")), IoError);
    EXPECT_THROW(load_scene(read_scene_file(folder_ / "m.json")), IoError);
    fs::remove_all(outside);
}

TEST_F(SceneLibraryTest, AGeneratedSceneStandsAtItsOrigin) {
    write("ball.json", kSphere);
    const Scene scene = load_scene(read_scene_file(folder_ / "ball.json"));
    EXPECT_GT(scene.tree.voxel_count(), 500u);
    EXPECT_EQ(scene.voxel_size_m, 0.5);
    EXPECT_EQ(scene.corner_m, Vec3(1, 2, 3));
    EXPECT_EQ(scene.to_voxels({2, 2, 3}), Vec3(2, 0, 0));
    EXPECT_EQ(scene.to_metres({2, 0, 0}), Vec3(2, 2, 3));
    EXPECT_EQ(scene.sha256.size(), 64u);
    EXPECT_FALSE(scene.inside_voxel({1e6, 0, 0}));
    // From the corner the farthest voxel is a diagonal of 16 m away.
    EXPECT_NEAR(scene.reach_m({1, 2, 3}), 16.0 * std::sqrt(3.0), 1e-9);
}

TEST_F(SceneLibraryTest, AVoxSceneKeepsTheFilesOwnOrigin) {
    const auto seeds = test::vox_seeds();
    ASSERT_FALSE(seeds.empty());
    write_file_atomically(folder_ / "Model.vox", seeds.front().second);
    write("model.json", R"({"type": "vox", "file": "Model.vox", "voxel_size_m": 0.1})");
    const Scene scene = load_scene(read_scene_file(folder_ / "model.json"));
    EXPECT_GT(scene.tree.voxel_count(), 0u);
    const VoxImport import = import_vox(seeds.front().second, "Model.vox");
    EXPECT_NE(import.lowest, IVec3(0));
    EXPECT_EQ(scene.corner_m, Vec3(import.lowest) * 0.1);
    EXPECT_EQ(scene.to_metres(Vec3(0.0)), scene.corner_m);
}

TEST_F(SceneLibraryTest, TheCacheGivesBackTheSameScene) {
    write("ball.json", kSphere);
    const SceneFile file = read_scene_file(folder_ / "ball.json");
    const auto cache = folder_ / "cache" / "deep";
    const Scene first = load_scene(file, cache);
    const Scene second = load_scene(file, cache);
    EXPECT_FALSE(first.load.from_cache);
    EXPECT_TRUE(second.load.from_cache);
    EXPECT_TRUE(second.tree == first.tree);
    EXPECT_EQ(second.corner_m, first.corner_m);
    EXPECT_EQ(second.sha256, first.sha256);

    // A damaged cache file is made anew.
    const auto cached = cache / (first.sha256 + ".voxtree");
    std::vector<std::byte> bytes = read_file(cached);
    bytes[bytes.size() / 2] ^= std::byte{1};
    write_file_atomically(cached, bytes);
    const Scene third = load_scene(file, cache);
    EXPECT_FALSE(third.load.from_cache);
    EXPECT_TRUE(third.tree == first.tree);
    EXPECT_TRUE(load_scene(file, cache).load.from_cache);

    // A cache that cannot be written is a warning.
    write("file-not-folder", "");
    const Scene uncached = load_scene(file, folder_ / "file-not-folder");
    ASSERT_EQ(uncached.warnings.size(), 1u);
    EXPECT_NE(uncached.warnings[0].find("cache was not written"), std::string::npos);
}

TEST_F(SceneLibraryTest, AChangedFileIsAnotherScene) {
    write("ball.json", kSphere);
    const std::string before = content_sha256(read_scene_file(folder_ / "ball.json"));
    write("ball.json", std::string(kSphere) + " ");
    EXPECT_NE(content_sha256(read_scene_file(folder_ / "ball.json")), before);
}

TEST_F(SceneLibraryTest, SaysWhatIsWrongWithASceneFile) {
    EXPECT_EQ(problem_of(kSphere), "none");
    const std::pair<const char*, const char*> cases[] = {
        {"{", "(document): not JSON"},
        {R"({"type": "mesh"})", "/type: expected one of \"generator\", \"vox\", \"heightmap\""},
        {R"({"type": "vox", "file": "a.vox"})", "/voxel_size_m: is required"},
        {R"({"type": "vox", "file": "a.vox", "voxel_size_m": 0})", "/voxel_size_m: is 0"},
        {R"({"type": "vox", "file": "../a.vox", "voxel_size_m": 1})", "/file: expected the name"},
        {R"({"type": "vox", "file": "/a.vox", "voxel_size_m": 1})", "/file: expected the name"},
        {R"({"type": "vox", "file": ".hidden", "voxel_size_m": 1})", "/file: expected the name"},
        {R"({"type": "generator", "generator": "jungle"})", "/generator: "},
        {R"({"type": "generator", "generator": "sphere", "size": 33})", "/generator: "},
        {R"({"type": "generator", "generator": "sphere", "sise": 32})", "/sise: is unknown"},
    };
    for (const auto& [text, expected] : cases) {
        EXPECT_EQ(problem_of(text).substr(0, std::string(expected).size()), expected) << text;
    }
}

}  // namespace
}  // namespace probebake
