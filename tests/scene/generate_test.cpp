// What holds for every generated world, at sizes that take a fraction of a second.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <ostream>
#include <set>
#include <stdexcept>

#include "math/random.h"
#include "scene/generators/generators.h"
#include "voxels/trace.h"

namespace probebake {
namespace {

const Vec3 kDown(0.0, -1.0, 0.0);

VoxelCloud generate_with(int threads, const GeneratorParams& params) {
    // More threads than this machine may have cores.
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
    VoxelCloud cloud;
    tbb::task_arena(threads).execute([&] { cloud = generate(params); });
    return cloud;
}

bool same_voxels(const VoxelCloud& a, const VoxelCloud& b) {
    return a.depth == b.depth && a.emission_scale == b.emission_scale &&
           std::equal(a.voxels.begin(), a.voxels.end(), b.voxels.begin(), b.voxels.end(),
                      [](const Voxel& v, const Voxel& w) {
                          return v.key == w.key && v.albedo == w.albedo && v.emission == w.emission;
                      });
}

/// FNV-1a over the positions and colours of the finished world, in tree order.
uint64_t fingerprint(const VoxelTree& tree) {
    uint64_t hash = 0xCBF29CE484222325ull;
    const auto add = [&](uint64_t value) { hash = (hash ^ value) * 0x100000001B3ull; };
    for (const VoxelNode& node : tree.nodes()) add(node.mask);
    for (const PackedRgb albedo : tree.colors().albedo.voxels) add(albedo);
    for (const PackedRgb emission : tree.colors().emission.voxels) add(emission);
    return hash;
}

/// Height of the highest voxel of every `step`-th column, −1 where there is none.
std::vector<int> surface(const VoxelTree& tree, int step) {
    const int size = 1 << tree.depth();
    std::vector<int> heights;
    for (int z = step / 2; z < size; z += step) {
        for (int x = step / 2; x < size; x += step) {
            const Hit hit = trace(tree, {Vec3(x + 0.37, size + 1.0, z + 0.61), kDown});
            heights.push_back(hit ? hit.corner.y : -1);
        }
    }
    return heights;
}

/// Rays from above that reach the bottom of the world: straight down through every column, and
/// aslant towards points well inside.
int count_leaks(const VoxelTree& tree) {
    const std::vector<int> heights = surface(tree, 1);
    auto leaks = static_cast<int>(std::count(heights.begin(), heights.end(), -1));
    const int size = 1 << tree.depth();
    const double margin = 0.1 * size;
    RandomStream random(random_key({7, static_cast<uint64_t>(size)}));
    for (int i = 0; i < 20000; ++i) {
        const Vec3 from{random.uniform() * size, 1.0 * size, random.uniform() * size};
        const Vec3 to{margin + random.uniform() * (size - 2.0 * margin), 0.0,
                      margin + random.uniform() * (size - 2.0 * margin)};
        leaks += trace(tree, {from, glm::normalize(to - from)}) ? 0 : 1;
    }
    return leaks;
}

void expect_sound(const VoxelCloud& cloud, int size) {
    EXPECT_EQ(1 << cloud.depth, size);
    EXPECT_FALSE(cloud.voxels.empty());
    for (const Voxel& voxel : cloud.voxels) {
        const IVec3 p = morton_decode(voxel.morton());
        ASSERT_LT(std::max({p.x, p.y, p.z}), size);
        const Rgb albedo = unpack_rgb(voxel.albedo);
        for (int c = 0; c < 3; ++c) {
            ASSERT_GT(albedo[c], 0.0f);
            ASSERT_LT(albedo[c], 1.0f);
        }
    }
}

struct Recorded {
    const char* name;
    uint64_t fingerprint;  // at 128 voxels, seed 1
};

void PrintTo(const Recorded& world, std::ostream* out) { *out << world.name; }

class Landscape : public testing::TestWithParam<Recorded> {};

// Scenes are known by (name, size, seed) in jobs, reports and caches: a generator that makes other
// voxels must change what scene_library.cpp hashes, and then the numbers below.
TEST_P(Landscape, IsTheSameOnAnyNumberOfThreads) {
    const GeneratorParams params{GetParam().name, 128, 1};
    VoxelCloud cloud = generate_with(1, params);
    expect_sound(cloud, params.size);
    EXPECT_TRUE(same_voxels(cloud, generate_with(4, params)));
    EXPECT_EQ(fingerprint(VoxelTree::build(std::move(cloud))), GetParam().fingerprint);
}

TEST_P(Landscape, IsClosedBelowAndOpenAbove) {
    const GeneratorParams params{GetParam().name, 256, 1};
    VoxelCloud cloud = generate(params);
    const VoxelTree tree = VoxelTree::build(cloud);
    EXPECT_EQ(count_leaks(tree), 0);
    // That the rays would find a hole: one column less.
    std::erase_if(cloud.voxels, [](const Voxel& voxel) {
        const IVec3 p = morton_decode(voxel.morton());
        return p.x == 100 && p.z == 180;
    });
    EXPECT_GT(count_leaks(VoxelTree::build(std::move(cloud))), 0);

    const std::vector<int> heights = surface(tree, 4);
    double sum = 0.0;
    for (const int y : heights) sum += y;
    const double mean = sum / static_cast<double>(heights.size()) / params.size;
    EXPECT_GT(mean, 0.08);
    EXPECT_LT(mean, 0.25);
    EXPECT_LT(*std::max_element(heights.begin(), heights.end()), params.size / 2);

    EXPECT_EQ(voxel_size_m(params), 2.0);
}

TEST_P(Landscape, ChangesWithTheSeedAndNotWithTheSize) {
    const VoxelTree coarse = VoxelTree::build(generate({GetParam().name, 64, 1}));
    const VoxelTree fine = VoxelTree::build(generate({GetParam().name, 128, 1}));
    const VoxelTree other = VoxelTree::build(generate({GetParam().name, 64, 2}));
    const std::vector<int> heights = surface(coarse, 1);
    const std::vector<int> fine_heights = surface(fine, 2);
    const std::vector<int> other_heights = surface(other, 1);
    double finer = 0.0;
    double elsewhere = 0.0;
    for (size_t i = 0; i < heights.size(); ++i) {
        finer += std::abs(8.0 * heights[i] - 4.0 * fine_heights[i]);
        elsewhere += std::abs(8.0 * (heights[i] - other_heights[i]));
    }
    const auto columns = static_cast<double>(heights.size());
    // In metres: trees come and go with the resolution, hills with the seed.
    EXPECT_LT(finer / columns, 7.0);
    EXPECT_GT(elsewhere, 1.2 * finer);
}

INSTANTIATE_TEST_SUITE_P(Generate, Landscape,
                         testing::Values(Recorded{"desert", 12828964446828080318ull},
                                         Recorded{"forest", 10527698478931956169ull},
                                         Recorded{"mountain", 743487460611979886ull},
                                         Recorded{"biomes", 15227971916259145677ull}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Generate, ListsGeneratorsWithUniqueNames) {
    std::set<std::string_view> names;
    for (const GeneratorInfo& info : generators()) {
        EXPECT_TRUE(names.insert(info.name).second) << info.name;
        EXPECT_FALSE(info.description.empty()) << info.name;
        EXPECT_LE(info.min_size, info.max_size) << info.name;
    }
    for (const char* name :
         {"desert", "forest", "mountain", "biomes", "grating", "net", "cornell", "slackline",
          "canopy", "torch", "sphere", "box", "plane", "stairs", "single"}) {
        EXPECT_EQ(names.count(name), 1u) << name;
    }
}

TEST(Generate, StudiesAndShapesAreSoundAtTheirSmallestSize) {
    const std::set<std::string_view> landscapes = {"desert", "forest", "mountain", "biomes"};
    for (const GeneratorInfo& info : generators()) {
        if (landscapes.count(info.name) != 0) continue;
        SCOPED_TRACE(info.name);
        const GeneratorParams params{std::string(info.name), info.min_size, 3};
        VoxelCloud cloud = generate_with(1, params);
        expect_sound(cloud, params.size);
        EXPECT_TRUE(same_voxels(cloud, generate_with(4, params)));
    }
}

TEST(Generate, RefusesWhatItCannotMake) {
    for (const char* name : {"", "Forest", "forest ", "tundra"}) {
        EXPECT_THROW(generate({name, 256, 1}), std::invalid_argument) << name;
    }
    for (const int size : {-256, 0, 1, 32, 100, 257, 16384}) {
        EXPECT_THROW(generate({"forest", size, 1}), std::invalid_argument) << size;
        EXPECT_THROW(voxel_size_m({"forest", size, 1}), std::invalid_argument) << size;
    }
    EXPECT_THROW(generate({"cornell", 512, 1}), std::invalid_argument);
}

std::string refusal(const GeneratorParams& params) {
    try {
        generate(params);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

TEST(Generate, SaysWhatItExpected) {
    EXPECT_EQ(refusal({"forest", 100, 1}),
              "the size of a 'forest' world is a power of two from 64 to 8192 voxels, not 100");
    EXPECT_NE(refusal({"tundra", 256, 1}).find("expected one of desert, forest, mountain"),
              std::string::npos);
}

}  // namespace
}  // namespace probebake
