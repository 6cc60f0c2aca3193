// Light and skies on disk: read back as they were written, or refused.
#include "io/cache_folder.h"
#include "io/file.h"
#include "light/face_file.h"
#include "light/sky_file.h"
#include "light_fixture.h"
#include "support/temp_folder.h"

namespace probebake {
namespace {

LitScene lit(const VoxelTree& tree) {
    return test::light(tree, {.sun = Sun{{1.0, 2.0, 0.5}, Rgb(3.0f)}, .sky = Sky(Rgb(0.5f))});
}

VoxelTree room() {
    VoxelCloud cloud = test::flat_ground(5);
    test::add_room(cloud, {4, 1, 4}, {20, 12, 20});
    return VoxelTree::build(std::move(cloud));
}

TEST(LightFile, ReadsBackEveryFaceAndTheCost) {
    const test::TempFolder folder;
    const VoxelTree tree = room();
    const LitScene made = lit(tree);
    save_light(folder.path() / "a.light", made);
    const LitScene read = load_light(folder.path() / "a.light", tree);
    EXPECT_EQ(read.colors, made.colors);
    EXPECT_EQ(read.cost.sky_rays, made.cost.sky_rays);
    EXPECT_EQ(read.cost.steps, made.cost.steps);
}

TEST(LightFile, DamageAndAnotherTreeAreRefused) {
    const test::TempFolder folder;
    const std::filesystem::path path = folder.path() / "a.light";
    const VoxelTree tree = room();
    save_light(path, lit(tree));
    const VoxelTree other = VoxelTree::build(test::flat_ground(5));
    EXPECT_THROW(load_light(path, other), IoError);
    std::vector<std::byte> bytes = read_file(path);
    for (const size_t at : {size_t{3}, size_t{60}, bytes.size() / 2, bytes.size() - 1}) {
        std::vector<std::byte> damaged = bytes;
        damaged[at] ^= std::byte{16};
        write_file_atomically(path, damaged);
        EXPECT_THROW(load_light(path, tree), IoError) << at;
    }
    bytes.resize(bytes.size() - 9);
    write_file_atomically(path, bytes);
    EXPECT_THROW(load_light(path, tree), IoError);
}

TEST(SkyCache, ReadsBackThePicture) {
    const test::TempFolder folder;
    auto image = std::make_shared<Image>(8, 4);
    image->at(3, 2) = Rgb(1e5f, 0.25f, 0.0f);
    const std::string sha256(64, 'a');
    save_sky(folder.path() / "a.sky", {image, sha256});
    const SkyFile read = load_sky(folder.path() / "a.sky");
    EXPECT_EQ(*read.image, *image);
    EXPECT_EQ(read.sha256, sha256);

    image->at(0, 0).g = std::numeric_limits<float>::quiet_NaN();
    save_sky(folder.path() / "nan.sky", {image, sha256});
    EXPECT_THROW(load_sky(folder.path() / "nan.sky"), IoError);
    save_sky(folder.path() / "square.sky", {std::make_shared<Image>(8, 8), sha256});
    EXPECT_THROW(load_sky(folder.path() / "square.sky"), IoError);
}

TEST(CacheFolder, WhatWasNotUsedForLongestGoesFirst) {
    const test::TempFolder folder;
    const auto path = [&](const char* name) { return folder.path() / name; };
    for (const char* name : {"a", "b", "c"}) {
        write_file_atomically(path(name), std::string(100, 'x'));
        std::filesystem::last_write_time(
            path(name), std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
    }
    mark_used(path("b"));
    trim_cache(folder.path(), 100);
    EXPECT_FALSE(std::filesystem::exists(path("a")));
    EXPECT_TRUE(std::filesystem::exists(path("b")));
    EXPECT_FALSE(std::filesystem::exists(path("c")));
    trim_cache(path("nowhere"), 0);
}

}  // namespace
}  // namespace probebake
