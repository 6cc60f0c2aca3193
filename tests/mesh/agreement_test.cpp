#include <gtest/gtest.h>

#include <string>

#include "mesh/mesh_rays.h"
#include "mesh/mesh_worlds.h"

namespace probebake {
namespace {

TEST(MeshAgreement, EveryHitOfAxisRaysLiesInAVoxel) {
    const TriangleMesh level = test::make_level(24, 40, 100.0, 3);
    const TriangleMesh soup = test::make_soup(300, 60.0, 4);
    for (const TriangleMesh* const mesh : {&level, &soup}) {
        const GridMesh grid = make_grid_mesh(*mesh, 0.25);
        const MeshSurface surface(*mesh, grid);
        const test::MeshRays rays(grid);
        VoxelisedMesh made = voxelise(*mesh, {.voxel_size_m = 0.25});
        const test::RayCheck check = test::check_axis_rays(grid, surface, rays, made.tree, 30'000);
        EXPECT_GT(check.hits, 20'000u);
        EXPECT_EQ(check.outside, 0u);
        // The same rays find holes, where there are some.
        VoxelCloud thinned{.depth = made.tree.depth()};
        uint32_t at = 0;
        made.tree.for_each_voxel([&](const IVec3& p) {
            if (++at % 50 != 0) thinned.voxels.push_back(make_voxel(p, 1));
        });
        EXPECT_GT(
            test::check_axis_rays(grid, surface, rays, VoxelTree::build(thinned), 3'000).outside,
            10u);
    }
}

TEST(MeshAgreement, RaysEndWithinAVoxelOfTheSurface) {
    const TriangleMesh level = test::make_level(24, 40, 100.0, 5);
    const test::Agreement fine = test::compare(level, 0.1, 20'000, 1);
    EXPECT_EQ(fine.rays, 20'000u);
    EXPECT_EQ(fine.behind, 0u);
    EXPECT_GE(fine.share(fine.agree), 0.999);
    EXPECT_GT(fine.same_surface, 18'000u);
    EXPECT_EQ(fine.within_cosine, fine.same_surface);
    // Along the ray they may be farther apart: voxels stand out before a surface, and a ray at a
    // grazing angle meets them that much earlier. docs/decisions.md has what is to be expected.
    EXPECT_GT(fine.share(fine.along), 0.65);
    EXPECT_LT(fine.share(fine.past), 0.02);
    const test::Agreement coarse = test::compare(level, 1.0, 5'000, 1);
    EXPECT_EQ(coarse.behind, 0u);
    EXPECT_GE(coarse.share(coarse.agree), 0.999);
    EXPECT_GT(coarse.share(coarse.past), 3.0 * fine.share(fine.past));
    RecordProperty("along", std::to_string(fine.share(fine.along)));
    RecordProperty("past", std::to_string(fine.share(fine.past)));
    RecordProperty("agree", std::to_string(fine.share(fine.agree)));
}

}  // namespace
}  // namespace probebake
