// A level of a million triangles on a grid of 4096³. Prints what it took: run it by itself, the
// peak is the process's.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <iostream>

#include "mesh/mesh_worlds.h"
#include "mesh/voxelise.h"

namespace probebake {
namespace {

uint64_t peak_resident_bytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

double megabytes(uint64_t bytes) { return static_cast<double>(bytes) / 1e6; }

TEST(VoxeliseSlow, AMillionTrianglesOn4096CubedFitInFourGigabytes) {
    const TriangleMesh mesh = test::make_level(700, 2000, 1000.0, 1);
    EXPECT_GT(mesh.triangles.size(), 1'000'000u);
    const uint64_t before = peak_resident_bytes();
    const VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = 1000.0 / 4094.0});
    const VoxeliseReport& report = made.report;
    std::cout << report.triangles << " triangles, " << report.voxels << " voxels, depth "
              << made.tree.depth() << ", " << report.seconds << " s, own buffers "
              << megabytes(report.peak_bytes) << " MB, tree " << megabytes(made.tree.memory_bytes())
              << " MB, process " << megabytes(peak_resident_bytes()) << " MB (mesh and before "
              << megabytes(before) << " MB), Hausdorff "
              << report.hausdorff_m / report.voxel_diagonal_m << " diagonals, "
              << report.uncovered_points << " of " << report.checked_points
              << " points uncovered\n";
    EXPECT_EQ(made.tree.depth(), 12);
    EXPECT_EQ(report.uncovered_points, 0u);
    EXPECT_LE(report.hausdorff_m, report.voxel_diagonal_m);
    EXPECT_LT(peak_resident_bytes(), uint64_t{4} << 30);
}

}  // namespace
}  // namespace probebake
