// The study scenes have the geometry that their headers promise.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "math/random.h"
#include "scene/generators/cornell.h"
#include "scene/generators/generators.h"
#include "scene/generators/studies.h"
#include "voxels/trace.h"

namespace probebake {
namespace {

VoxelTree make(const char* name, int size) { return VoxelTree::build(generate({name, size, 1})); }

std::vector<IVec3> emissive_voxels(const VoxelCloud& cloud) {
    std::vector<IVec3> found;
    for (const Voxel& voxel : cloud.voxels) {
        if (voxel.emission != 0) found.push_back(morton_decode(voxel.morton()));
    }
    return found;
}

class Cornell : public testing::Test {
  protected:
    static const VoxelTree& tree() {
        static const VoxelTree made = make("cornell", cornell::kMinWorld);
        return made;
    }
};

TEST_F(Cornell, StandsOnAFloorOverTheWholeWorld) {
    for (int z = 0; z < cornell::kMinWorld; ++z) {
        for (int x = 0; x < cornell::kMinWorld; ++x) {
            ASSERT_TRUE(tree().occupied({x, cornell::kFloorY, z}));
            ASSERT_FALSE(tree().occupied({x, cornell::kFloorY - 1, z}));
        }
    }
    EXPECT_EQ(cornell::kBoxMin.y, cornell::kFloorY + 1);
    EXPECT_EQ(cornell::kBoxMax - cornell::kBoxMin, IVec3(32));
}

TEST_F(Cornell, HasWallsAGratingAndAPanel) {
    using namespace cornell;
    for (int z = kBoxMin.z - 2; z < kBoxMax.z + 2; ++z) {
        for (int y = kBoxMin.y; y < kBoxMax.y + 2; ++y) {
            for (int x = kBoxMin.x - 2; x < kBoxMax.x + 2; ++x) {
                const IVec3 v(x, y, z);
                const bool in_box = glm::all(glm::greaterThanEqual(v, kBoxMin)) &&
                                    glm::all(glm::lessThan(v, kBoxMax));
                const bool wall = x == kBoxMin.x || x == kBoxMax.x - 1 || y == kBoxMin.y ||
                                  y == kBoxMax.y - 1 || z == kBoxMin.z;
                const bool bar = z == kGratingZ && x % 2 == 0;
                const bool light = glm::all(glm::greaterThanEqual(v, kLightMin)) &&
                                   glm::all(glm::lessThan(v, kLightMax));
                ASSERT_EQ(tree().occupied(v), in_box && (wall || bar || light))
                    << x << " " << y << " " << z;
            }
        }
    }
}

TEST_F(Cornell, ShinesFromThePanelOnly) {
    const VoxelCloud cloud = generate({"cornell", cornell::kMinWorld, 1});
    const std::vector<IVec3> lights = emissive_voxels(cloud);
    EXPECT_EQ(lights.size(), 64u);
    for (const IVec3& v : lights) {
        EXPECT_TRUE(glm::all(glm::greaterThanEqual(v, cornell::kLightMin)) &&
                    glm::all(glm::lessThan(v, cornell::kLightMax)));
    }
}

TEST_F(Cornell, BeamPassesTheGratingAtFullDetailOnly) {
    RandomStream random(random_key({9, 1}));
    int passed = 0;
    int passed_coarse = 0;
    constexpr int kRays = 4000;
    for (int i = 0; i < kRays; ++i) {
        const Vec3 floor{280.0 + 20.0 * (random.uniform() - 0.5), cornell::kFloorY + 1.01,
                         320.0 + 200.0 * random.uniform()};
        const Vec3 light{268.0 + 8.0 * random.uniform(), 268.0 + 8.0 * random.uniform(), 258.01};
        const Vec3 way = light - floor;
        const double distance = glm::length(way);
        const Ray ray{floor, way / distance};
        const TraceRange range{0.0, distance - 0.01};
        passed += trace(tree(), ray, {}, range) ? 0 : 1;
        // Coarse only where the ray meets the box, as with a level of detail by distance.
        const TraceRange beyond{5.0, distance - 0.01};
        passed_coarse += trace(tree(), ray, {1, 0.0}, beyond) ? 0 : 1;
    }
    // Half of the front is open; oblique bars take a little more.
    EXPECT_GT(passed, kRays * 4 / 10);
    EXPECT_LT(passed, kRays * 6 / 10);
    EXPECT_EQ(passed_coarse, 0);
}

TEST(Torch, HasOneEmissiveVoxel) {
    const VoxelCloud cloud = generate({"torch", 128, 1});
    const std::vector<IVec3> lights = emissive_voxels(cloud);
    ASSERT_EQ(lights.size(), 1u);
    const VoxelTree tree = VoxelTree::build(cloud);
    const Rgb radiance = worldgen::kTorchRadiance;
    const auto index = tree.find_voxel(lights[0]);
    ASSERT_TRUE(index);
    const Rgb stored = tree.colors().emission[{ColorIndex::Array::kVoxels, *index}];
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(stored[c], radiance[c], 0.004f * radiance.r);
}

TEST(Grating, HasBarsOfOneVoxelAtFourPeriods) {
    constexpr int kSize = 256;
    const VoxelTree tree = make("grating", kSize);
    // Row 1 has bars along z: along x, a lying panel is `period` apart.
    const int tile = kSize / 4;
    const int y = kSize / 8 + 2 * tile / 8;
    const int z = tile + tile / 8 + 1;
    const std::array<int, 4> periods = {2, 3, 4, 8};
    for (int column = 0; column < 4; ++column) {
        const int begin = column * tile + tile / 8;
        for (int u = 0; u < 3 * tile / 4; ++u) {
            EXPECT_EQ(tree.occupied({begin + u, y, z}),
                      u % periods[static_cast<size_t>(column)] == 0);
        }
        EXPECT_FALSE(tree.occupied({begin, y + 1, z}));
    }
}

TEST(Net, HangsInOnePieceAboveTheGround) {
    constexpr int kSize = 128;
    const VoxelTree tree = make("net", kSize);
    // Along a rope every column holds a rope voxel that touches the next one's.
    int last_low = 0;
    int last_high = 0;
    for (int x = 0; x < kSize; ++x) {
        int low = kSize;
        int high = 0;
        for (int y = kSize / 8 + 8; y < kSize; ++y) {
            if (!tree.occupied({x, y, 64})) continue;
            low = std::min(low, y);
            high = std::max(high, y);
        }
        ASSERT_LE(low, high) << x;
        if (x > 0) {
            EXPECT_TRUE(low <= last_high + 1 && last_low <= high + 1) << x;
        }
        last_low = low;
        last_high = high;
    }
}

TEST(Slackline, IsOneVoxelThick) {
    constexpr int kSize = 256;
    const VoxelTree tree = make("slackline", kSize);
    // Halfway between the trees a vertical slice meets the line once, above the ground.
    int found = 0;
    for (int z = kSize / 4; z < 3 * kSize / 4; ++z) {
        for (int y = kSize / 8; y < kSize / 8 + kSize / 12; ++y) {
            found += tree.occupied({kSize / 2, y, z}) ? 1 : 0;
        }
    }
    EXPECT_GE(found, 1);
    EXPECT_LE(found, 2);
}

TEST(Canopy, LetsSomeRaysThrough) {
    constexpr int kSize = 256;
    const VoxelTree tree = make("canopy", kSize);
    int open = 0;
    for (int z = 0; z < kSize; ++z) {
        for (int x = 0; x < kSize; ++x) {
            const Hit hit = trace(tree, {Vec3(x + 0.5, kSize, z + 0.5), Vec3(0.0, -1.0, 0.0)});
            ASSERT_TRUE(hit);
            open += hit.corner.y == kSize / 8 - 1 ? 1 : 0;
        }
    }
    // Three independent layers of half cover let an eighth through.
    EXPECT_GT(open, kSize * kSize / 20);
    EXPECT_LT(open, kSize * kSize / 4);
}

TEST(Shapes, AreClosedAndHollow) {
    constexpr int kSize = 64;
    RandomStream random(random_key({9, 2}));
    for (const char* name : {"sphere", "box"}) {
        const VoxelTree tree = make(name, kSize);
        EXPECT_FALSE(tree.occupied(IVec3(kSize / 2))) << name;
        for (int i = 0; i < 5000; ++i) {
            Vec3 d;
            do {
                d = Vec3{random.uniform(), random.uniform(), random.uniform()} * 2.0 - 1.0;
            } while (glm::dot(d, d) > 1.0 || glm::dot(d, d) < 0.01);
            EXPECT_TRUE(trace(tree, {Vec3(0.5 * kSize + 0.1), glm::normalize(d)})) << name;
        }
    }
    const VoxelTree ball = make("sphere", kSize);
    const Hit side = trace(ball, {Vec3(0.5 * kSize + 0.1), Vec3(1.0, 0.0, 0.0)});
    EXPECT_NEAR(side.t, 0.375 * kSize - 1.0, 1.5);
}

TEST(Shapes, HaveTheirCounts) {
    EXPECT_EQ(make("single", 16).voxel_count(), 1u);
    EXPECT_TRUE(make("single", 16).occupied({8, 8, 8}));
    EXPECT_EQ(make("plane", 64).voxel_count(), 64u * 64u);
    EXPECT_EQ(make("box", 64).voxel_count(), 32u * 32u * 32u - 30u * 30u * 30u);
    const VoxelTree stairs = make("stairs", 64);
    std::set<int> treads;
    for (int x = 0; x < 64; ++x) {
        treads.insert(trace(stairs, {Vec3(x + 0.5, 65.0, 8.5), Vec3(0.0, -1.0, 0.0)}).corner.y);
    }
    EXPECT_EQ(treads.size(), 16u);
    EXPECT_EQ(*treads.rbegin(), 31);
}

}  // namespace
}  // namespace probebake
