#include "voxels/solid_fill.h"

#include <gtest/gtest.h>

#include <deque>

#include "support/random_cloud.h"

namespace probebake {
namespace {

/// Positions that have no way out, by a flood voxel by voxel.
std::vector<IVec3> closed_in(const VoxelTree& tree) {
    const int side = 1 << tree.depth();
    std::vector<char> reached(size_t{1} << (3 * tree.depth()));
    const auto at = [&](const IVec3& p) -> char& {
        return reached[static_cast<size_t>((p.z * side + p.y) * side + p.x)];
    };
    std::deque<IVec3> open;
    const auto reach = [&](const IVec3& p) {
        for (int axis = 0; axis < 3; ++axis) {
            if (p[axis] < 0 || p[axis] >= side) return;
        }
        if (at(p) != 0 || tree.occupied(p)) return;
        at(p) = 1;
        open.push_back(p);
    };
    std::vector<IVec3> inside;
    for (int pass = 0; pass < 2; ++pass) {
        for (int z = 0; z < side; ++z) {
            for (int y = 0; y < side; ++y) {
                for (int x = 0; x < side; ++x) {
                    const IVec3 p(x, y, z);
                    const bool border = glm::any(glm::equal(p, IVec3(0))) ||
                                        glm::any(glm::equal(p, IVec3(side - 1)));
                    if (pass == 0 && border) reach(p);
                    if (pass == 1 && at(p) == 0 && !tree.occupied(p)) inside.push_back(p);
                }
            }
        }
        while (!open.empty()) {
            const IVec3 p = open.front();
            open.pop_front();
            for (int axis = 0; axis < 3; ++axis) {
                for (const int step : {-1, 1}) {
                    IVec3 beside = p;
                    beside[axis] += step;
                    reach(beside);
                }
            }
        }
    }
    return inside;
}

/// Voxels on the border of [low, high].
VoxelCloud shell(int depth, const IVec3& low, const IVec3& high) {
    VoxelCloud cloud{.depth = depth};
    for (int z = low.z; z <= high.z; ++z) {
        for (int y = low.y; y <= high.y; ++y) {
            for (int x = low.x; x <= high.x; ++x) {
                const IVec3 p(x, y, z);
                if (glm::any(glm::equal(p, low)) || glm::any(glm::equal(p, high))) {
                    cloud.voxels.push_back(make_voxel(p, 7));
                }
            }
        }
    }
    return cloud;
}

TEST(SolidFill, FillsAClosedShellAndNoOpenOne) {
    for (const int depth : {4, 5}) {
        const IVec3 low(1, 2, 3);
        const IVec3 high(9, 12, 14);
        VoxelCloud cloud = shell(depth, low, high);
        const uint64_t voxels = cloud.voxels.size();
        const VoxelTree tree = VoxelTree::build(cloud);
        const SolidFill solid = fill_solid(tree, 1u << 20);
        EXPECT_EQ(solid.filled, 7u * 9 * 10);
        EXPECT_EQ(solid.tree.voxel_count(), voxels + solid.filled);
        EXPECT_TRUE(solid.tree.occupied({5, 6, 7}));
        EXPECT_FALSE(solid.tree.occupied({0, 6, 7}));
        EXPECT_EQ(solid.tree.colors().albedo.voxels[*solid.tree.find_voxel({5, 6, 7})], 7u);
        // One voxel less, and the air of outside comes in.
        std::erase_if(cloud.voxels, [](const Voxel& voxel) {
            return morton_decode(voxel.morton()) == IVec3(5, 12, 8);
        });
        const VoxelTree open = VoxelTree::build(cloud);
        const SolidFill hollow = fill_solid(open, 1u << 20);
        EXPECT_EQ(hollow.filled, 0u);
        EXPECT_EQ(hollow.tree, open);
    }
}

/// Shells that touch the border of the world, corners that touch: what the flood must not get
/// wrong.
TEST(SolidFill, FillsWhatAFloodVoxelByVoxelDoesNotReach) {
    uint64_t filled = 0;
    for (const int depth : {2, 3, 4, 5}) {
        for (const double density : {0.3, 0.5, 0.7, 0.8, 0.95}) {
            for (uint64_t seed = 0; seed < 6; ++seed) {
                const VoxelTree tree = VoxelTree::build(test::random_cloud(depth, density, seed));
                const std::vector<IVec3> inside = closed_in(tree);
                const SolidFill solid = fill_solid(tree, 1u << 20);
                ASSERT_EQ(solid.filled, inside.size()) << depth << " " << density << " " << seed;
                for (const IVec3& p : inside) ASSERT_TRUE(solid.tree.occupied(p));
                filled += solid.filled;
            }
        }
    }
    EXPECT_GT(filled, 1000u);
}

TEST(SolidFill, KeepsColoursAndRefusesTooMuch) {
    VoxelCloud cloud = shell(5, IVec3(3), IVec3(20));
    for (Voxel& voxel : cloud.voxels) voxel.albedo = static_cast<PackedRgb>(voxel.morton());
    cloud.voxels[5].emission = 9;
    cloud.emission_scale = 4.0f;
    const VoxelTree tree = VoxelTree::build(cloud);
    const SolidFill solid = fill_solid(tree, 1u << 20);
    ASSERT_GT(solid.filled, 0u);
    EXPECT_EQ(solid.tree.colors().emission.scale, 4.0f);
    for (const Voxel& voxel : cloud.voxels) {
        const auto at = solid.tree.find_voxel(morton_decode(voxel.morton()));
        ASSERT_TRUE(at);
        EXPECT_EQ(solid.tree.colors().albedo.voxels[*at], voxel.albedo);
        EXPECT_EQ(solid.tree.colors().emission.voxels[*at], voxel.emission);
    }
    EXPECT_THROW(fill_solid(tree, tree.voxel_count() + solid.filled - 1), std::invalid_argument);
    EXPECT_NO_THROW(fill_solid(tree, tree.voxel_count() + solid.filled));
    EXPECT_EQ(fill_solid(VoxelTree(), 10).filled, 0u);
}

}  // namespace
}  // namespace probebake
