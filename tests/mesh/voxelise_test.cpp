#include "mesh/voxelise.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <numeric>

#include "mesh/grid_mesh.h"
#include "mesh/mesh_worlds.h"
#include "mesh/triangle_box.h"
#include "support/ray_families.h"
#include "voxels/trace.h"

namespace probebake {
namespace {

TEST(Voxelise, HasTheVoxelsThatTrianglesTouchAndNoOthers) {
    for (const double size_m : {0.31, 0.5}) {
        const TriangleMesh mesh = test::make_soup(60, 16.0, 1);
        const VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = size_m});
        const GridMesh grid = make_grid_mesh(mesh, size_m);
        std::vector<TriangleBox> boxes;
        for (const GridTriangle& t : grid.triangles) boxes.emplace_back(t.vertices);
        const int side = 1 << made.tree.depth();
        uint64_t expected = 0;
        for (int z = 0; z < side; ++z) {
            for (int y = 0; y < side; ++y) {
                for (int x = 0; x < side; ++x) {
                    const IVec3 low = IVec3(x, y, z) * kGridUnits;
                    const bool touched = std::any_of(
                        boxes.begin(), boxes.end(),
                        [&](const TriangleBox& box) { return box.overlaps(low, kGridUnits); });
                    expected += touched ? 1 : 0;
                    ASSERT_EQ(made.tree.occupied({x, y, z}), touched) << x << ' ' << y << ' ' << z;
                }
            }
        }
        EXPECT_GT(expected, 1000u);
        EXPECT_EQ(made.report.voxels, expected);
        EXPECT_EQ(made.report.triangles, 60u);
        EXPECT_GT(made.report.checked_points, 90'000u);
        EXPECT_EQ(made.report.uncovered_points, 0u);
        EXPECT_LE(made.report.hausdorff_m, made.report.voxel_diagonal_m);
        EXPECT_GT(made.report.hausdorff_m, 0.5 * made.report.voxel_diagonal_m);
    }
}

TEST(Voxelise, IsTheSameForAnyOrderAndAnyNumberOfThreads) {
    const TriangleMesh mesh = test::make_soup(150, 40.0, 2);
    TriangleMesh shuffled = mesh;
    RandomStream random(7);
    std::vector<uint32_t> places(mesh.positions.size());
    std::iota(places.begin(), places.end(), uint32_t{0});
    for (size_t i = places.size(); i-- > 1;) std::swap(places[i], places[random.below(i + 1)]);
    for (size_t i = 0; i < places.size(); ++i) shuffled.positions[places[i]] = mesh.positions[i];
    for (MeshTriangle& triangle : shuffled.triangles) {
        for (uint32_t& vertex : triangle.vertices) vertex = places[vertex];
        std::rotate(triangle.vertices.begin(),
                    triangle.vertices.begin() + static_cast<std::ptrdiff_t>(random.below(3)),
                    triangle.vertices.end());
    }
    for (size_t i = shuffled.triangles.size(); i-- > 1;) {
        std::swap(shuffled.triangles[i], shuffled.triangles[random.below(i + 1)]);
    }
    VoxelisedMesh one;
    VoxelisedMesh three;
    tbb::task_arena(1).execute([&] { one = voxelise(mesh, {.voxel_size_m = 0.2}); });
    tbb::task_arena(3).execute([&] { three = voxelise(shuffled, {.voxel_size_m = 0.2}); });
    EXPECT_GT(one.tree.depth(), 7);  // of more than one block
    EXPECT_FALSE(one.tree.colors().emission.empty());
    EXPECT_TRUE(one.tree == three.tree);
    EXPECT_EQ(one.report.hausdorff_m, three.report.hausdorff_m);
}

TEST(Voxelise, ClosedBoxesLetNothingOutHoweverTheyAreTurned) {
    RandomStream random(11);
    uint64_t rays = 0;
    for (int turn = 0; turn < 40; ++turn) {
        TriangleMesh mesh;
        test::add_material(mesh, Rgb(0.5f));
        // The first ones have their faces on planes of the grid, all have walls without thickness.
        const glm::dmat3 turned = turn < 2 ? glm::dmat3(1.0) : test::random_rotation(random);
        const Vec3 half = turn == 0 ? Vec3(4.0)
                                    : Vec3(2.0) + 3.0 * Vec3(random.uniform(), random.uniform(),
                                                             random.uniform());
        test::add_box(mesh, Vec3(0.0), half, turned);
        const std::optional<Vec3> corner =
            turn == 0 ? std::optional(Vec3(-8.0)) : std::optional<Vec3>();
        const VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = 0.5, .corner_m = corner});
        for (int i = 0; i < 2000; ++i, ++rays) {
            const Vec3 inside =
                turned * (0.6 * half * (2.0 * test::random_point(random, 1.0) - Vec3(1.0)));
            const Vec3 direction =
                i % 3 == 0 ? test::random_diagonal(random) : test::random_direction(random);
            // From the middle of a voxel diagonals run through edges and corners.
            Vec3 origin = (inside - made.corner_m) / 0.5;
            if (i % 2 == 0) origin = glm::floor(origin) + 0.5;
            ASSERT_TRUE(trace(made.tree, {origin, direction})) << "turn " << turn << ", ray " << i;
        }
    }
    EXPECT_EQ(rays, 80'000u);
}

/// A way out across faces, edges and corners of empty voxels.
bool leaks(const VoxelTree& tree, const IVec3& from) {
    const int side = 1 << tree.depth();
    std::vector<bool> seen(static_cast<size_t>(side) * static_cast<size_t>(side * side));
    std::vector<IVec3> open{from};
    while (!open.empty()) {
        const IVec3 at = open.back();
        open.pop_back();
        for (int i = 0; i < 27; ++i) {
            const IVec3 next = at + IVec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            if (glm::any(glm::lessThan(next, IVec3(0))) ||
                glm::any(glm::greaterThanEqual(next, IVec3(side)))) {
                return true;
            }
            const auto index = static_cast<size_t>((next.z * side + next.y) * side + next.x);
            if (seen[index] || tree.occupied(next)) continue;
            seen[index] = true;
            open.push_back(next);
        }
    }
    return false;
}

TEST(Voxelise, WhatIsClosedInIsApartEvenAcrossCorners) {
    RandomStream random(12);
    for (int turn = 0; turn < 8; ++turn) {
        TriangleMesh mesh;
        test::add_material(mesh, Rgb(0.5f));
        test::add_box(mesh, Vec3(0.0), Vec3(5.0, 4.0, 3.0), test::random_rotation(random));
        const VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = 0.4, .corner_m = Vec3(-10.0)});
        EXPECT_FALSE(leaks(made.tree, IVec3(25)));
        // A wall less, and the same search gets out.
        mesh.triangles.resize(mesh.triangles.size() - 2);
        EXPECT_TRUE(
            leaks(voxelise(mesh, {.voxel_size_m = 0.4, .corner_m = Vec3(-10.0)}).tree, IVec3(25)));
    }
}

TEST(Voxelise, WhatIsModelledOnTheGridIsOneVoxelThick) {
    TriangleMesh mesh;
    test::add_material(mesh, Rgb(0.5f));
    test::add_quad(mesh, {0, 3, 0}, {4, 3, 0}, {4, 3, 4}, {0, 3, 4});
    const VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = 1.0});
    EXPECT_EQ(made.corner_m, Vec3(-0.5, 2.5, -0.5));
    EXPECT_EQ(made.report.voxels, 25u);
    const VoxelisedMesh shifted = voxelise(mesh, {.voxel_size_m = 1.0, .corner_m = Vec3(-1.0)});
    EXPECT_EQ(shifted.report.voxels, 2u * 36u);  // both sides of every plane: it is closed
}

TEST(Voxelise, RefusesWhatDoesNotFit) {
    TriangleMesh mesh;
    test::add_material(mesh, Rgb(0.5f));
    test::add_box(mesh, Vec3(0.0), Vec3(10.0));
    EXPECT_THROW(voxelise(mesh, {.voxel_size_m = 0.0}), std::invalid_argument);
    EXPECT_THROW(voxelise(mesh, {.voxel_size_m = std::nan("")}), std::invalid_argument);
    EXPECT_THROW(voxelise(mesh, {.voxel_size_m = 1e-4}), std::invalid_argument);
    EXPECT_THROW(voxelise(mesh, {.voxel_size_m = 1.0, .corner_m = Vec3(0.0)}),
                 std::invalid_argument);
    EXPECT_THROW(voxelise(mesh, {.voxel_size_m = 0.5, .max_voxels = 5000}), std::invalid_argument);
    EXPECT_THROW(voxelise(mesh, {.voxel_size_m = 0.5, .max_memory_bytes = 10'000}),
                 std::invalid_argument);
    EXPECT_NO_THROW(voxelise(mesh, {.voxel_size_m = 0.5}));
    mesh.positions[3].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(voxelise(mesh, {.voxel_size_m = 0.5}), std::invalid_argument);
    EXPECT_EQ(voxelise(TriangleMesh{}, {.voxel_size_m = 0.5}).report.voxels, 0u);
}

TEST(Voxelise, SolidFillsWhatABoxClosesInHoweverItIsTurned) {
    RandomStream random(11);
    for (int i = 0; i < 12; ++i) {
        TriangleMesh mesh;
        test::add_material(mesh, {0.5f, 0.5f, 0.5f});
        const Vec3 half(6.0 + 3.0 * random.uniform(), 7.0, 4.0 + 5.0 * random.uniform());
        const glm::dmat3 turned = i == 0 ? glm::dmat3(1.0) : test::random_rotation(random);
        test::add_box(mesh, Vec3(16.0), half, turned);
        const double size_m = 0.37;
        const VoxelisedMesh shell = voxelise(mesh, {.voxel_size_m = size_m});
        const VoxelisedMesh solid = voxelise(mesh, {.voxel_size_m = size_m, .solid = true});
        EXPECT_EQ(shell.report.filled_voxels, 0u);
        EXPECT_EQ(solid.report.voxels, shell.report.voxels + solid.report.filled_voxels);
        EXPECT_EQ(solid.report.hausdorff_m, shell.report.hausdorff_m);
        const double volume = 8.0 * half.x * half.y * half.z / (size_m * size_m * size_m);
        // A voxel on the surface stands out by half of itself, more or less.
        EXPECT_GT(static_cast<double>(solid.report.voxels), volume);
        EXPECT_LT(static_cast<double>(solid.report.filled_voxels), volume);
        for (int k = 0; k < 2000; ++k) {
            const Vec3 unit(2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0,
                            2.0 * random.uniform() - 1.0);
            const Vec3 at = (Vec3(16.0) + turned * (half * unit) - solid.corner_m) / size_m;
            ASSERT_TRUE(solid.tree.occupied(IVec3(glm::floor(at)))) << i << ' ' << k;
        }
    }
}

TEST(Voxelise, SolidLeavesAnOpenBoxHollow) {
    TriangleMesh mesh;
    test::add_material(mesh, {0.5f, 0.5f, 0.5f});
    test::add_box(mesh, Vec3(8.0), Vec3(6.0));
    mesh.triangles.resize(10);  // without its last side
    const VoxelisedMesh shell = voxelise(mesh, {.voxel_size_m = 0.5});
    const VoxelisedMesh solid = voxelise(mesh, {.voxel_size_m = 0.5, .solid = true});
    EXPECT_EQ(solid.report.filled_voxels, 0u);
    EXPECT_EQ(solid.tree, shell.tree);
}

}  // namespace
}  // namespace probebake
