#include "scene/suggest_probes.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "scene/generators/generators.h"
#include "voxels/trace.h"

namespace probebake {
namespace {

Scene scene_of(const GeneratorParams& params) {
    Scene scene;
    scene.tree = VoxelTree::build(generate(params));
    scene.voxel_size_m = voxel_size_m(params);
    scene.corner_m = {100.0, -20.0, 3.0};
    return scene;
}

TEST(SuggestProbes, LiesInFreeAirAboveTheGroundAllOverALandscape) {
    const Scene scene = scene_of({"forest", 128, 1});
    const std::vector<Vec3> probes = suggest_probes(scene, 16);
    EXPECT_EQ(probes.size(), 16u);
    std::set<int> quarters;
    for (const Vec3& probe : probes) {
        EXPECT_FALSE(scene.inside_voxel(probe));
        const Vec3 p = scene.to_voxels(probe);
        const Hit below = trace(scene.tree, {p, {0.0, -1.0, 0.0}});
        ASSERT_TRUE(below);
        EXPECT_GE(below.t * scene.voxel_size_m, 2.0);
        EXPECT_LE(below.t * scene.voxel_size_m, 11.0);
        quarters.insert((p.x < 64 ? 0 : 1) + (p.z < 64 ? 0 : 2));
    }
    EXPECT_EQ(quarters.size(), 4u);
    EXPECT_EQ(probes, suggest_probes(scene, 16));
    EXPECT_NE(probes, suggest_probes(scene, 16, 2));
}

TEST(SuggestProbes, PrefersWhatHasGroundBelow) {
    // Four islands; all between them is empty.
    VoxelCloud cloud;
    cloud.depth = 8;
    for (const IVec3& island : {IVec3(20, 5, 20), IVec3(180, 9, 40), IVec3(30, 7, 190)}) {
        for (int i = 0; i < 48 * 48; ++i) {
            cloud.voxels.push_back(make_voxel(island + IVec3(i % 48, 0, i / 48), 1));
        }
    }
    Scene scene;
    scene.tree = VoxelTree::build(std::move(cloud));
    const std::vector<Vec3> probes = suggest_probes(scene, 4);
    ASSERT_EQ(probes.size(), 4u);
    int grounded = 0;
    for (const Vec3& probe : probes) {
        const Hit below = trace(scene.tree, {scene.to_voxels(probe), {0.0, -1.0, 0.0}});
        grounded += below ? 1 : 0;
        EXPECT_LT(scene.to_voxels(probe).y, 30.0);  // not in the sky of a flat world
    }
    EXPECT_EQ(grounded, 3);
}

TEST(SuggestProbes, FindsRoomInEveryGeneratedScene) {
    for (const GeneratorInfo& info : generators()) {
        const Scene scene = scene_of({std::string(info.name), info.min_size, 3});
        const std::vector<Vec3> probes = suggest_probes(scene, 8);
        EXPECT_GE(probes.size(), 1u) << info.name;
        for (const Vec3& probe : probes) {
            EXPECT_FALSE(scene.inside_voxel(probe)) << info.name;
            const Vec3 p = scene.to_voxels(probe);
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_GT(p[axis], 0.0) << info.name;
                EXPECT_LT(p[axis], info.min_size) << info.name;
            }
        }
    }
}

TEST(SuggestProbes, NoneWhereNoneAreAskedForOrNothingIsThere) {
    const Scene plane = scene_of({"plane", 16, 1});
    EXPECT_TRUE(suggest_probes(plane, 0).empty());
    EXPECT_THROW(suggest_probes(plane, -1), std::invalid_argument);
    Scene empty;
    empty.tree = VoxelTree::build({});
    EXPECT_TRUE(suggest_probes(empty, 8).empty());
}

}  // namespace
}  // namespace probebake
