#include "light/shadow_ray.h"

#include <cmath>

#include "light/light_fixture.h"
#include "support/ray_families.h"

namespace probebake {
namespace {

TEST(ShadowRay, StartsOnTheFaceAndNeverMeetsItsOwnVoxel) {
    // Far from the world's origin, where an epsilon would be lost or too large; grazing directions.
    VoxelCloud cloud;
    cloud.depth = 16;
    const IVec3 at(65000, 40123, 33333);
    cloud.voxels.push_back(make_voxel(at, pack_rgb(Rgb(0.5f))));
    const VoxelTree tree = VoxelTree::build(cloud);
    RandomStream random(5);
    for (int i = 0; i < 20000; ++i) {
        const int face = static_cast<int>(random.below(6));
        Vec3 point(at);
        point += test::random_point(random, 1.0);
        point[face / 2] = at[face / 2] + (face % 2 == 0 ? 1.0 : 0.0);
        Vec3 direction = test::random_direction(random);
        const double up = std::pow(10.0, -12.0 * random.uniform());
        direction[face / 2] = face % 2 == 0 ? up : -up;
        ASSERT_TRUE(cast_shadow_ray(tree, {point, glm::normalize(direction)}, 1e9).visible);
        // And whatever stands on the face is met at once.
        direction[face / 2] = -direction[face / 2];
        const ShadowResult into = cast_shadow_ray(tree, {point, glm::normalize(direction)}, 1e9);
        ASSERT_TRUE(up < 1e-9 || !into.visible);
    }
}

TEST(ShadowRay, EndsAtTheLight) {
    VoxelCloud cloud = test::flat_ground(5);
    test::add_box(cloud, {0, 10, 0}, {32, 11, 32});
    const VoxelTree tree = VoxelTree::build(std::move(cloud));
    const Ray up{{16.5, 1.0, 16.5}, {0.0, 1.0, 0.0}};
    EXPECT_TRUE(cast_shadow_ray(tree, up, 8.9).visible);
    EXPECT_TRUE(cast_shadow_ray(tree, up, 9.0).visible);  // a light on the ceiling itself
    const ShadowResult behind = cast_shadow_ray(tree, up, 9.5);
    EXPECT_FALSE(behind.visible);
    EXPECT_EQ(behind.blocker.t, 9.0);
    // A node that holds the light does not hide it.
    for (const ShadowLod lod : {ShadowLod::kDistance, ShadowLod::kNode, ShadowLod::kSubtree}) {
        EXPECT_TRUE(cast_shadow_ray(tree, up, 9.0, {.lod = lod, .cone = 10.0}).visible);
    }
}

TEST(ShadowRay, PointLightsFallOffWithTheSquareOfTheDistance) {
    const Rgb intensity(10.0f, 20.0f, 40.0f);
    EXPECT_EQ(point_irradiance(intensity, 1.0, 1.0), intensity);
    EXPECT_EQ(point_irradiance(intensity, 2.0, 0.5), intensity / 8.0f);
    EXPECT_EQ(point_irradiance(intensity, 2.0, -0.5), Rgb(0.0f));
}

/// A grating of one-voxel bars, half open: Müller 2020, 3.2.2.
class GratingTest : public testing::Test {
  protected:
    GratingTest() {
        VoxelCloud cloud;
        cloud.depth = 8;
        for (int y = 0; y < 64; ++y) {
            for (int x = 0; x < 64; x += 2) {
                cloud.voxels.push_back(make_voxel({x, y, 200}, pack_rgb(Rgb(0.5f))));
            }
        }
        test::add_box(cloud, {128, 0, 200}, {192, 64, 204});  // and a wall of four voxels
        tree_ = VoxelTree::build(std::move(cloud));
    }

    /// Share of the rays from z = 0 that get past z = 200 within [x, x + 64).
    double visible_share(double x, const ShadowSettings& settings) {
        RandomStream random(9);
        int seen = 0;
        for (int i = 0; i < 4000; ++i) {
            const Vec3 to(x + 1.0 + 62.0 * random.uniform(), 1.0 + 62.0 * random.uniform(), 230.0);
            const Vec3 from(to.x + random.uniform() - 0.5, to.y, 0.0);
            const double distance = glm::length(to - from);
            seen +=
                cast_shadow_ray(tree_, {from, (to - from) / distance}, distance, settings).visible
                    ? 1
                    : 0;
        }
        return seen / 4000.0;
    }
    VoxelTree tree_;
};

TEST_F(GratingTest, DistanceClosesItAndTheErrorOpensItAgain) {
    const double leaves = visible_share(0.0, {});
    EXPECT_NEAR(leaves, 0.5, 0.03);
    // Nodes of edge 2, 4 and 8 from 64, 128 and 256 voxels away: here 4.
    const double cone = 1.0 / 32.0;
    EXPECT_EQ(visible_share(0.0, {.lod = ShadowLod::kDistance, .cone = cone}), 0.0);
    EXPECT_EQ(visible_share(0.0, {.lod = ShadowLod::kSubtree, .cone = cone}), leaves);
    EXPECT_EQ(visible_share(128.0, {}), 0.0);
    for (const ShadowLod lod : {ShadowLod::kDistance, ShadowLod::kNode, ShadowLod::kSubtree}) {
        EXPECT_EQ(visible_share(128.0, {.lod = lod, .cone = cone}), 0.0);
    }
    const ShadowResult solid =
        cast_shadow_ray(tree_, {{160.3, 32.2, 0.0}, {0.0, 0.0, 1.0}}, 230.0, {.cone = cone});
    EXPECT_EQ(solid.blocker.level, 2);
    EXPECT_EQ(solid.errors_asked, 8u + 1u);
}

TEST_F(GratingTest, TheThesissFormulaSeesOneLevelBelowANodeOnly) {
    // With nodes of edge 8 the bars are two levels below the children: with a decay of 0.2 the node
    // looks solid enough, all light is lost. The maximum over the subtree still sees them.
    const double cone = 1.0 / 16.0;
    const double leaves = visible_share(0.0, {});
    EXPECT_EQ(visible_share(0.0, {.lod = ShadowLod::kNode, .cone = cone}), 0.0);
    EXPECT_EQ(visible_share(0.0, {.lod = ShadowLod::kSubtree, .cone = cone}), leaves);
}

}  // namespace
}  // namespace probebake
