// The landscapes at 2048 voxels, beside Müller 2020, table 4.1.
#include <gtest/gtest.h>

#include <cstdio>
#include <ostream>
#include <string>

#include "scene/generators/generators.h"
#include "voxels/voxel_tree.h"

namespace probebake {
namespace {

struct World {
    const char* name;
    double voxels;           // of the thesis, millions
    double least, most;      // that ours may have
    double nodes_per_voxel;  // of the thesis
};

void PrintTo(const World& world, std::ostream* out) { *out << world.name; }

class GenerateWorld : public testing::TestWithParam<World> {};

TEST_P(GenerateWorld, HasTheCountsOfTheThesis) {
    const World& expected = GetParam();
    BuildStats stats;
    const VoxelTree tree = VoxelTree::build(generate({expected.name, 2048, 1}), &stats);
    const double voxels = static_cast<double>(tree.voxel_count()) * 1e-6;
    const double ratio =
        static_cast<double>(tree.octree_node_count()) / static_cast<double>(tree.voxel_count());
    std::printf("%-9s %6.2f M voxels (thesis %5.2f), %.3f octree nodes per voxel (thesis %.3f)\n",
                expected.name, voxels, expected.voxels, ratio, expected.nodes_per_voxel);
    EXPECT_GE(voxels, expected.least);
    EXPECT_LE(voxels, expected.most);
    EXPECT_GE(ratio, 1.40);
    EXPECT_LE(ratio, 1.45);
}

INSTANTIATE_TEST_SUITE_P(Landscapes, GenerateWorld,
                         testing::Values(World{"desert", 18.63, 14.0, 20.0, 1.397},
                                         World{"forest", 28.12, 25.0, 30.0, 1.452},
                                         World{"mountain", 26.44, 23.0, 28.0, 1.450},
                                         World{"biomes", 14.59, 14.0, 16.0, 1.450}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace probebake
