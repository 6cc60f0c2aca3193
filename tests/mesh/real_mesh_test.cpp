// What voxels keep of real meshes: where rays end, what they show. Prints the figures of
// docs/results/meshes.md.
#include <gtest/gtest.h>

#include <iomanip>
#include <iostream>

#include "mesh/mesh_rays.h"
#include "mesh/real_meshes.h"

namespace probebake {
namespace {

constexpr int kResolution = 1024;

class RealMeshTest : public testing::TestWithParam<test::RealMesh> {
  protected:
    void SetUp() override {
        file_ = test::mesh_file_of(GetParam(), kResolution);
        if (!file_) GTEST_SKIP() << "no " << GetParam().file << " in PROBEBAKE_DATA";
        mesh_ = load_mesh(*file_);
        voxel_size_m_ = mesh_voxel_size_m(*file_, mesh_);
    }

    std::optional<MeshFile> file_;
    TriangleMesh mesh_;
    double voxel_size_m_ = 0.0;
};

TEST_P(RealMeshTest, RaysEndWithinAVoxelOfTheSurface) {
    const test::Agreement found = test::compare(mesh_, voxel_size_m_, 20'000, 1);
    const auto percent = [](uint64_t part, uint64_t of) {
        return 100.0 * static_cast<double>(part) / static_cast<double>(of);
    };
    const uint64_t both = found.rays - found.past;
    std::cout << std::setprecision(5) << GetParam().name << ": " << found.rays << " rays, behind "
              << found.behind << ", within a diagonal of the surface "
              << percent(found.agree, found.rays) << " %, past " << percent(found.past, found.rays)
              << " %, same surface " << percent(found.same_surface, both)
              << " % (of these within a diagonal over the cosine "
              << percent(found.within_cosine, found.same_surface) << " %), along the ray "
              << percent(found.along, both) << " %, of " << found.steep << " steep ones "
              << percent(found.steep_along, found.steep) << " %\n";
    EXPECT_EQ(found.rays, 20'000u);
    EXPECT_EQ(found.behind, 0u);
    EXPECT_GE(found.share(found.agree), 0.999);
    EXPECT_EQ(found.within_cosine, found.same_surface);
}

TEST_P(RealMeshTest, AxisRaysSeeTheColoursOfVoxels) {
    const GridMesh grid = make_grid_mesh(mesh_, voxel_size_m_);
    const MeshSurface surface(mesh_, grid);
    const test::MeshRays rays(grid);
    const VoxelisedMesh made = voxelise(mesh_, {.voxel_size_m = voxel_size_m_});
    const test::RayCheck check = test::check_axis_rays(grid, surface, rays, made.tree, 100'000);
    const auto share = [&](uint64_t part) {
        return static_cast<double>(part) / static_cast<double>(check.hits);
    };
    std::cout << std::setprecision(5) << GetParam().name << ": " << made.report.triangles
              << " triangles, " << made.report.voxels << " voxels, " << made.report.seconds
              << " s, Hausdorff at most " << made.report.hausdorff_m << " m (diagonal "
              << made.report.voxel_diagonal_m << " m); axis rays: " << check.hits << " hits, "
              << check.outside << " outside, albedo within 1/32 "
              << 100.0 * share(check.same_albedo) << " %, mean difference "
              << check.albedo_difference / static_cast<double>(check.hits) << ", "
              << check.emissive_hits << " emissive, of these in dark voxels " << check.dark_voxels
              << ", dark ones in emissive voxels " << check.emissive_voxels_unseen << '\n';
    EXPECT_GT(check.hits, 10'000u);
    EXPECT_EQ(check.outside, 0u);
    EXPECT_EQ(made.report.uncovered_points, 0u);
    EXPECT_LE(made.report.hausdorff_m, made.report.voxel_diagonal_m);
    EXPECT_GT(share(check.same_albedo), 0.9);
    EXPECT_EQ(check.dark_voxels, 0u);
}

INSTANTIATE_TEST_SUITE_P(Meshes, RealMeshTest, testing::ValuesIn(test::kRealMeshes),
                         [](const auto& of) {
                             std::string name = of.param.name;
                             std::replace(name.begin(), name.end(), ' ', '_');
                             return name;
                         });

}  // namespace
}  // namespace probebake
