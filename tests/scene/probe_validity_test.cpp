#include "scene/probe_validity.h"

#include <gtest/gtest.h>

#include <cmath>

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
    const ProbePlace wall = look_at_place(scene, {1.0, 8.0, 0.1});
    EXPECT_TRUE(wall.inside_geometry);
    EXPECT_EQ(wall.backface, 1.0);
    EXPECT_EQ(wall.nearest_surface_m, 0.0);
    EXPECT_FALSE(wall.is_valid(0.9));
    const ProbePlace air = look_at_place(scene, {5.3, 8.0, 0.1});
    EXPECT_FALSE(air.inside_geometry);
    EXPECT_EQ(air.backface, 0.0);
    EXPECT_NEAR(air.nearest_surface_m, 3.3, 1e-12);
    EXPECT_TRUE(air.is_valid(0.0));
    const ProbePlace beside = look_at_place(scene, {2.01, 8.0, 0.1});
    EXPECT_FALSE(beside.inside_geometry);
    EXPECT_NEAR(beside.backface, 0.5, 0.05);
    EXPECT_FALSE(beside.is_valid(kDefaultMaxBackface));
    EXPECT_EQ(look_at_place(Scene{}, Vec3(1.0)).nearest_surface_m,
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
            const double found = look_at_place(scene, 2.0 * p).nearest_surface_m;
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
    const Vec3 cell(3.0);
    for (const double x : {0.1, 0.9, 1.1, 1.9}) {
        const Vec3 from(x, 8.0, 0.1);
        const Vec3 to = relocated(scene, from, kMostCellShare * cell);
        EXPECT_TRUE(look_at_place(scene, to).is_valid(kDefaultMaxBackface)) << x;
        EXPECT_EQ(to.x > 1.0, x > 1.0) << x;
        EXPECT_EQ(to.y, from.y);
        EXPECT_EQ(to.z, from.z);
        EXPECT_LE(std::abs(to.x - from.x), kMostCellShare * cell.x + 1e-12);
    }
}

TEST(ProbeValidity, WhatIsWellStaysBitForBit) {
    const Scene scene = walled(4);
    RandomStream random(3);
    for (int i = 0; i < 50; ++i) {
        const Vec3 p(2.6 + 5.0 * random.uniform(), 1.0 + 14.0 * random.uniform(),
                     -7.0 + 14.0 * random.uniform());
        EXPECT_EQ(relocated(scene, p, Vec3(1.0)), p);
    }
}

TEST(ProbeValidity, WhereAllIsSolidAProbeStaysAndIsInvalid) {
    Scene scene;
    scene.tree = VoxelTree::build(test::random_cloud(4, 2.0, 1));
    const Vec3 p(8.3, 7.7, 8.1);
    EXPECT_EQ(relocated(scene, p, Vec3(4.0)), p);
    EXPECT_FALSE(look_at_place(scene, p).is_valid(0.99));
    EXPECT_EQ(relocated(scene, p, Vec3(0.0)), p);
    const Vec3 bad(std::nan(""), 0.0, 0.0);
    EXPECT_FALSE(look_at_place(scene, bad).inside_geometry);  // an answer, no crash
}

}  // namespace
}  // namespace probebake
