#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "support/random_cloud.h"
#include "voxels/filled_box.h"
#include "voxels/voxel_tree.h"

namespace probebake {
namespace {

/// The octree the slow way: every non-empty node's position at every level.
std::vector<std::set<uint64_t>> nodes_by_level(const VoxelCloud& cloud) {
    std::vector<std::set<uint64_t>> levels(static_cast<size_t>(cloud.depth) + 1);
    for (const Voxel& voxel : cloud.voxels) {
        for (size_t level = 0; level < levels.size(); ++level) {
            levels[level].insert(voxel.morton() >> (3 * level));
        }
    }
    return levels;
}

TEST(BuildTree, HoldsExactlyTheVoxelsGiven) {
    for (const auto& [name, cloud] : test::named_clouds()) {
        const VoxelTree tree = VoxelTree::build(cloud);
        std::map<uint64_t, uint32_t> expected;
        for (const Voxel& voxel : cloud.voxels) {
            uint32_t& color = expected[voxel.morton()];
            color = std::max(color, voxel.albedo);
        }
        ASSERT_EQ(tree.voxel_count(), expected.size()) << name;
        uint32_t index = 0;
        for (const auto& [code, color] : expected) {  // Morton order is the tree's order
            const auto found = tree.find_voxel(morton_decode(code));
            ASSERT_TRUE(found.has_value()) << name;
            ASSERT_EQ(*found, index++) << name;
            ASSERT_EQ(tree.colors().albedo.voxels[*found], color) << name;
        }
        auto next = expected.begin();
        tree.for_each_voxel([&, &name = name](const IVec3& position) {
            ASSERT_EQ(position, morton_decode((next++)->first)) << name;
        });
        ASSERT_EQ(next, expected.end()) << name;
        RandomStream random(5);
        for (int i = 0; i < 2000; ++i) {
            const uint64_t code = random.below(uint64_t{1} << (3 * cloud.depth));
            ASSERT_EQ(tree.occupied(morton_decode(code)), expected.contains(code)) << name;
        }
        EXPECT_FALSE(tree.occupied({-1, 0, 0}));
        EXPECT_FALSE(tree.occupied({0, 1 << cloud.depth, 0}));
    }
}

TEST(FilledBox, TouchesVoxelsOnEverySide) {
    for (const auto& [name, cloud] : test::named_clouds()) {
        const Box box = filled_box(VoxelTree::build(cloud));
        IVec3 low(1 << kMaxDepth);
        IVec3 high(-1);
        for (const Voxel& voxel : cloud.voxels) {
            low = glm::min(low, morton_decode(voxel.morton()));
            high = glm::max(high, morton_decode(voxel.morton()));
        }
        if (cloud.voxels.empty()) {
            EXPECT_GT(box.low.x, box.high.x) << name;
            continue;
        }
        EXPECT_EQ(box.low, Vec3(low)) << name;
        EXPECT_EQ(box.high, Vec3(high + 1)) << name;
    }
}

TEST(BuildTree, CountsTheOctreeNodesOfEveryLevel) {
    for (const auto& [name, cloud] : test::named_clouds()) {
        const VoxelTree tree = VoxelTree::build(cloud);
        const auto levels = nodes_by_level(cloud);
        const std::vector<uint64_t> counts = tree.octree_nodes_per_level();
        uint64_t total = 0;
        for (size_t level = 0; level < levels.size(); ++level) {
            EXPECT_EQ(counts[level], levels[level].size()) << name << " level " << level;
            total += levels[level].size();
        }
        EXPECT_EQ(tree.octree_node_count(), total) << name;
    }
}

TEST(BuildTree, InnerColoursAreMeansOfTheirChildren) {
    const VoxelCloud cloud = test::random_cloud(5, 0.1, 11);
    const VoxelTree tree = VoxelTree::build(cloud);
    // Means level by level in double, keyed by (level, Morton code).
    std::vector<std::map<uint64_t, Vec3>> means(6);
    for (const Voxel& voxel : cloud.voxels) {
        means[0][voxel.morton()] = Vec3(unpack_rgb(voxel.albedo));
    }
    for (size_t level = 1; level < means.size(); ++level) {
        std::map<uint64_t, int> children;
        for (const auto& [code, color] : means[level - 1]) {
            means[level][code >> 3] += color;
            ++children[code >> 3];
        }
        for (auto& [code, color] : means[level]) color /= children[code];
    }
    const ColorLevels& albedo = tree.colors().albedo;
    size_t node = 0;
    size_t octant = 0;
    for (int k = tree.node_levels() - 1; k >= 0; --k) {  // arrays run from the root down
        const auto check = [&](size_t level, PackedRgb packed, const Vec3& expected) {
            const Rgb got = unpack_rgb(packed);
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(got[c], expected[c], 1.0 / 512) << level;
        };
        const auto node_level = static_cast<size_t>(2 * k + 2);
        if (node_level < means.size()) {
            for (const auto& [code, color] : means[node_level]) {
                check(node_level, albedo.nodes[node++], color);
            }
        } else {
            ++node;  // the root node of an odd depth holds one octant
        }
        for (const auto& [code, color] : means[node_level - 1]) {
            check(node_level - 1, albedo.octants[octant++], color);
        }
    }
    EXPECT_EQ(node, albedo.nodes.size());
    EXPECT_EQ(octant, albedo.octants.size());
}

TEST(BuildTree, EmissionIsKeptApartAndOnlyWhereSomethingEmits) {
    VoxelCloud dark{.voxels = {make_voxel({0, 0, 0}, 5), make_voxel({1, 0, 0}, 6)}};
    EXPECT_TRUE(VoxelTree::build(dark).colors().emission.empty());
    VoxelCloud lit = dark;
    lit.emission_scale = 1024.0f;
    lit.voxels[0].emission = pack_rgb(Rgb(2.0f, 0.0f, 0.0f));
    const VoxelTree tree = VoxelTree::build(lit);
    const ColorLevels& emission = tree.colors().emission;
    ASSERT_EQ(emission.voxels.size(), 2u);
    const ColorIndex voxel{ColorIndex::Array::kVoxels, 0};
    const ColorIndex octant{ColorIndex::Array::kOctants, 0};
    EXPECT_EQ(emission[voxel], Rgb(2048.0f, 0.0f, 0.0f));
    EXPECT_EQ(emission[octant], Rgb(1024.0f, 0.0f, 0.0f));
    EXPECT_EQ(tree.colors().albedo.voxels[0], 5u);
}

TEST(BuildTree, TheLaterInstanceWinsASharedPosition) {
    VoxelCloud cloud;
    for (const uint16_t order : std::initializer_list<uint16_t>{3, 9, 1}) {
        cloud.voxels.push_back(make_voxel({2, 1, 3}, 100u + order, 0, order));
    }
    BuildStats stats;
    const VoxelTree tree = VoxelTree::build(cloud, &stats);
    EXPECT_EQ(tree.voxel_count(), 1u);
    EXPECT_EQ(stats.duplicates, 2u);
    EXPECT_EQ(tree.colors().albedo.voxels[0], 109u);
}

TEST(BuildTree, TheSameForAnyOrderAndThreadCount) {
    VoxelCloud cloud = test::random_cloud(7, 0.15, 21);  // 300k voxels: several chunks
    const VoxelTree expected = VoxelTree::build(cloud);
    RandomStream random(3);
    for (size_t i = cloud.voxels.size(); i > 1; --i) {
        std::swap(cloud.voxels[i - 1], cloud.voxels[random.below(i)]);
    }
    for (const int threads : {1, 2, 7}) {
        tbb::task_arena arena(threads);
        arena.execute([&] { EXPECT_TRUE(VoxelTree::build(cloud) == expected) << threads; });
    }
}

TEST(BuildTree, RefusesWhatDoesNotFit) {
    VoxelCloud outside{.voxels = {make_voxel({4, 0, 0}, 1)}};
    EXPECT_THROW(VoxelTree::build(outside), std::invalid_argument);
    outside.depth = 3;
    EXPECT_EQ(VoxelTree::build(outside).voxel_count(), 1u);
    for (const int depth : {-1, 0, 1, 17}) {
        EXPECT_THROW(VoxelTree::build(VoxelCloud{.depth = depth}), std::invalid_argument);
    }
}

TEST(BuildTree, DepthForExtent) {
    EXPECT_EQ(depth_for_extent({1, 1, 1}), 2);
    EXPECT_EQ(depth_for_extent({4, 5, 1}), 3);
    EXPECT_EQ(depth_for_extent({2004, 253, 2045}), 11);
    EXPECT_EQ(depth_for_extent({2048, 1, 1}), 11);
    EXPECT_EQ(depth_for_extent({2049, 1, 1}), 12);
    EXPECT_EQ(depth_for_extent({65536, 1, 1}), 16);
    EXPECT_THROW(depth_for_extent({65537, 1, 1}), std::invalid_argument);
}

}  // namespace
}  // namespace probebake
