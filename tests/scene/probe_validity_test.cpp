#include "scene/probe_validity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mesh/mesh_worlds.h"
#include "mesh/voxelise.h"
#include "support/random_cloud.h"

namespace probebake {
namespace {

/// Air above y = 0 and a wall of `thick` voxels from x = 0 on; 0.5 m per voxel, 32 voxels a side.
Scene walled(int thick) {
    VoxelCloud cloud{.depth = 5};
    for (int z = 0; z < 32; ++z) {
        for (int y = 0; y < 32; ++y) {
            for (int x = 8; x < 8 + thick; ++x) cloud.voxels.push_back(make_voxel({x, y, z}, 1));
        }
    }
    Scene scene;
    scene.tree = VoxelTree::build(cloud);
    scene.voxel_size_m = 0.5;
    scene.corner_m = {-4.0, 0.0, -8.0};
    return scene;
}

TEST(ProbeValidity, TellsWallsFromAir) {
    const Scene scene = walled(4);  // from x = 0 to 2 m
    const PlaceFinder finder(scene, {}, true);
    EXPECT_EQ(finder.octree_bytes(), 0u);  // there is no mesh
    const ProbePlace wall = finder.look_at({1.0, 8.0, 0.1});
    EXPECT_TRUE(wall.inside_geometry);
    EXPECT_EQ(wall.closed_in, 1.0);
    EXPECT_EQ(wall.backface, std::nullopt);
    EXPECT_EQ(wall.nearest_surface_m, 0.0);
    EXPECT_FALSE(wall.valid);
    const ProbePlace air = finder.look_at({5.3, 8.0, 0.1});
    EXPECT_FALSE(air.inside_geometry);
    EXPECT_EQ(air.closed_in, 0.0);
    EXPECT_NEAR(air.nearest_surface_m, 3.3, 1e-12);
    EXPECT_TRUE(air.valid);
    const ProbePlace beside = finder.look_at({2.01, 8.0, 0.1});
    EXPECT_FALSE(beside.inside_geometry);
    EXPECT_NEAR(beside.closed_in, 0.5, 0.05);
    EXPECT_TRUE(beside.valid);
    EXPECT_FALSE(PlaceFinder(scene, {.max_closed_in = 0.4}, true).look_at({2.01, 8.0, 0.1}).valid);
    EXPECT_EQ(PlaceFinder(Scene{}, {}, false).look_at(Vec3(1.0)).nearest_surface_m,
              std::numeric_limits<double>::infinity());
}

TEST(ProbeValidity, NearestSurfaceIsThatOfAllVoxels) {
    for (const auto& [name, cloud] : test::named_clouds()) {
        Scene scene;
        scene.tree = VoxelTree::build(cloud);
        scene.voxel_size_m = 2.0;
        const double side = std::ldexp(1.0, cloud.depth);
        RandomStream random(9);
        for (int i = 0; i < 20; ++i) {
            const Vec3 p =
                side *
                (1.4 * Vec3(random.uniform(), random.uniform(), random.uniform()) - Vec3(0.2));
            double least = std::numeric_limits<double>::infinity();
            for (const Voxel& voxel : cloud.voxels) {
                const Vec3 low(morton_decode(voxel.morton()));
                least = std::min(least, glm::distance(p, glm::clamp(p, low, low + 1.0)));
            }
            const double found = PlaceFinder(scene, {}, false).look_at(2.0 * p).nearest_surface_m;
            if (cloud.voxels.empty()) {
                EXPECT_EQ(found, least) << name;
            } else {
                EXPECT_NEAR(found, 2.0 * least, 1e-9 * side) << name;
            }
        }
    }
}

TEST(ProbeValidity, ProbesLeaveWallsTheShortWayAndStayInTheirCell) {
    const Scene scene = walled(4);
    const PlaceFinder finder(scene, {}, false);
    const Vec3 cell(3.0);
    for (const double x : {0.1, 0.6, 1.4, 1.9}) {
        const Vec3 from(x, 8.0, 0.1);
        const Vec3 to = finder.relocated(from, kMostCellShare * cell);
        EXPECT_TRUE(finder.look_at(to).valid) << x;
        EXPECT_LE(finder.look_at(to).closed_in, 0.25) << x;
        EXPECT_EQ(to.x > 1.0, x > 1.0) << x;
        EXPECT_EQ(to.y, from.y);
        EXPECT_EQ(to.z, from.z);
        EXPECT_LE(std::abs(to.x - from.x), kMostCellShare * cell.x + 1e-12);
    }
}

TEST(ProbeValidity, WhatIsWellStaysBitForBit) {
    const Scene scene = walled(4);
    const PlaceFinder finder(scene, {}, false);
    RandomStream random(3);
    for (int i = 0; i < 50; ++i) {
        const Vec3 p(2.6 + 5.0 * random.uniform(), 1.0 + 14.0 * random.uniform(),
                     -7.0 + 14.0 * random.uniform());
        EXPECT_EQ(finder.relocated(p, Vec3(1.0)), p);
    }
}

TEST(ProbeValidity, WhereAllIsSolidAProbeStaysAndIsInvalid) {
    Scene scene;
    scene.tree = VoxelTree::build(test::random_cloud(4, 2.0, 1));
    const PlaceFinder finder(scene, {.max_backface = 1.0}, false);
    const Vec3 p(8.3, 7.7, 8.1);
    EXPECT_EQ(finder.relocated(p, Vec3(4.0)), p);
    EXPECT_FALSE(finder.look_at(p).valid);
    EXPECT_EQ(finder.relocated(p, Vec3(0.0)), p);
    const Vec3 bad(std::nan(""), 0.0, 0.0);
    EXPECT_FALSE(finder.look_at(bad).inside_geometry);  // an answer, no crash
}

/// Where no better place has more air, one with less will do.
TEST(ProbeValidity, ATightPlaceIsBetterThanNone) {
    VoxelCloud cloud{.depth = 4};
    for (int z = 0; z < 16; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) {
                if (x != 9) cloud.voxels.push_back(make_voxel({x, y, z}, 1));
            }
        }
    }
    Scene scene;
    scene.tree = VoxelTree::build(cloud);
    const PlaceFinder finder(scene, {}, false);
    const Vec3 to = finder.relocated({8.5, 8.5, 8.5}, Vec3(1.5));
    EXPECT_EQ(to, Vec3(9.0, 8.5, 8.5));  // of the lattice's places in the gap the nearest
    EXPECT_GT(finder.look_at(to).closed_in, 0.25);
}

TEST(ProbeValidity, TheGroundOfAHeightmapIsSolidThoughItsVoxelsAreAShell) {
    VoxelCloud cloud{.depth = 4};
    for (int z = 0; z < 16; ++z) {
        for (int x = 0; x < 16; ++x) cloud.voxels.push_back(make_voxel({x, 9, z}, 1));
    }
    Scene scene;
    scene.tree = VoxelTree::build(cloud);
    const Vec3 below(7.3, 4.2, 7.7);
    EXPECT_TRUE(PlaceFinder(scene, {}, false).look_at(below).valid);
    scene.solid_ground = true;
    const PlaceFinder finder(scene, {}, false);
    const ProbePlace place = finder.look_at(below);
    EXPECT_TRUE(place.inside_geometry);
    EXPECT_NEAR(place.nearest_surface_m, 4.8, 1e-12);
    EXPECT_FALSE(place.valid);
    EXPECT_TRUE(finder.look_at({7.3, 12.2, 7.7}).valid);
    EXPECT_GT(finder.relocated(below, Vec3(3.0, 8.0, 3.0)).y, 10.0);
}

Scene room(bool double_sided) {
    VoxelisedMesh made = voxelise(test::make_room(double_sided), {.voxel_size_m = 0.25});
    Scene scene;
    scene.tree = std::move(made.tree);
    scene.surface = std::move(made.surface);
    scene.corner_m = made.corner_m;
    scene.voxel_size_m = 0.25;
    return scene;
}

/// What voxels cannot tell apart: a room, and the inside of a hollow wall.
TEST(ProbeValidity, TrianglesTellRoomsFromWalls) {
    const Scene scene = room(false);
    const Vec3 middle(6.1, 5.9, 6.2);
    const Vec3 wall(1.1, 5.9, 6.2);
    const Vec3 outside(-3.0, 5.9, 6.2);
    const PlaceFinder voxels(scene, {}, false);
    EXPECT_EQ(voxels.octree_bytes(), 0u);
    for (const Vec3& p : {middle, wall, outside}) {
        EXPECT_TRUE(voxels.look_at(p).valid);
        EXPECT_EQ(voxels.look_at(p).backface, std::nullopt);
    }
    const PlaceFinder triangles(scene, {}, true);
    EXPECT_GT(triangles.octree_bytes(), 0u);
    EXPECT_EQ(triangles.look_at(middle).backface, 0.0);
    EXPECT_EQ(triangles.look_at(outside).backface, 0.0);
    const ProbePlace place = triangles.look_at(wall);
    EXPECT_EQ(place.backface, 1.0);
    EXPECT_FALSE(place.inside_geometry);
    EXPECT_FALSE(place.valid);
    const Vec3 moved = triangles.relocated(wall, Vec3(2.0));
    EXPECT_TRUE(triangles.look_at(moved).valid);
    EXPECT_EQ(triangles.look_at(moved).backface, 0.0);
    EXPECT_TRUE(PlaceFinder(scene, {.max_backface = 1.0}, true).look_at(wall).valid);
}

TEST(ProbeValidity, WhatHasTwoFrontsHasNoBack) {
    const Scene scene = room(true);
    const PlaceFinder finder(scene, {}, true);
    EXPECT_EQ(finder.octree_bytes(), 0u);
    EXPECT_EQ(finder.look_at({1.1, 5.9, 6.2}).backface, std::nullopt);
}

}  // namespace
}  // namespace probebake
