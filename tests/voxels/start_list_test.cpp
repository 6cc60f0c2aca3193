#include "voxels/start_list.h"

#include <gtest/gtest.h>

#include <string>

#include "support/random_cloud.h"
#include "support/ray_families.h"

namespace probebake {
namespace {

/// A beam around a direction, `half` wide to either side on the plane at distance 1.
struct TestBeam {
    Vec3 middle{0.0};
    Vec3 right{0.0};
    Vec3 down{0.0};
    Beam beam;

    TestBeam(const Vec3& origin, const Vec3& direction, double half, double cone)
        : middle(direction) {
        int smallest = 0;
        for (int axis = 1; axis < 3; ++axis) {
            if (std::abs(direction[axis]) < std::abs(direction[smallest])) smallest = axis;
        }
        Vec3 up(0.0);
        up[smallest] = 1.0;
        right = half * glm::normalize(glm::cross(direction, up));
        down = half * glm::normalize(glm::cross(right, direction));
        beam = {.origin = origin,
                .edges = {at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)},
                .width = 2.0 * half,
                .cone = cone};
    }
    Vec3 at(double u, double v) const { return middle + u * right + v * down; }
};

void expect_same(const Hit& got, const Hit& expected, const std::string& what) {
    ASSERT_EQ(got.level, expected.level) << what;
    if (!expected) return;
    ASSERT_EQ(got.t, expected.t) << what;
    ASSERT_EQ(got.corner, expected.corner) << what;
    ASSERT_EQ(got.point, expected.point) << what;
    ASSERT_EQ(got.entry_face, expected.entry_face) << what;
    for (auto k = static_cast<size_t>(std::max(0, expected.level - 1)) / 2; k < kMaxNodeLevels;
         ++k) {
        ASSERT_EQ(got.path[k], expected.path[k]) << what << " path " << k;
    }
}

/// Rays of beams of every family and width: corners and edges of the beam, and inside.
TEST(StartList, ChangesNothingThatARayMeets) {
    constexpr int kBeamsPerFamily = 60;
    uint64_t hits = 0;
    uint64_t nodes = 0;
    for (const auto& [cloud_name, cloud] : test::named_clouds()) {
        const VoxelTree tree = VoxelTree::build(cloud);
        for (const test::RayFamily& family : test::ray_families()) {
            if (!family.well_defined) continue;
            RandomStream random(random_key({7, std::hash<std::string>{}(family.name)}));
            for (int b = 0; b < kBeamsPerFamily; ++b) {
                const Ray ray = family.make(random, std::ldexp(1.0, cloud.depth));
                if (!is_finite(ray.origin) || glm::length(ray.direction) < 0.5) continue;
                const double half = std::ldexp(1.0, -static_cast<int>(random.below(12)));
                const TestBeam wide(ray.origin, ray.direction, half, half / 4.0);
                const TestBeam narrow(ray.origin, ray.direction, half / 8.0, half / 32.0);
                const StartList list = start_list(tree, wide.beam);
                const StartList inner = start_list(tree, narrow.beam, list);
                nodes += list.nodes.size();
                for (int i = 0; i < 25; ++i) {
                    const int row = i / 3;
                    const double u = i < 9 ? i % 3 - 1.0 : 2.0 * random.uniform() - 1.0;
                    const double v = i < 9 ? row - 1.0 : 2.0 * random.uniform() - 1.0;
                    for (const bool use_inner : {false, true}) {
                        const TestBeam& in = use_inner ? narrow : wide;
                        const StartList& from = use_inner ? inner : list;
                        const Ray cast{ray.origin, glm::normalize(in.at(u, v))};
                        const LevelOfDetail lod{.cone = in.beam.cone * random.uniform()};
                        const TraceRange range =
                            i % 4 == 3 ? TraceRange{.t_min = 1.5, .t_max = 19.0} : TraceRange{};
                        const HitBehind expected = trace_through(tree, cast, lod, range);
                        const HitBehind got = trace_through(tree, from, cast, lod, range);
                        const std::string what = cloud_name + ", " + family.name;
                        expect_same(got.leaf, expected.leaf, what);
                        expect_same(got.node, expected.node, what + ", LOD node");
                        expect_same(trace(tree, from, cast, range), expected.leaf, what);
                        ASSERT_LE(got.leaf.steps, expected.leaf.steps) << what;
                        if (expected.leaf) ++hits;
                    }
                }
            }
        }
    }
    EXPECT_GT(hits, 20'000u);
    EXPECT_GT(nodes, 10'000u);
}

TEST(StartList, OfNothingIsEmpty) {
    const VoxelTree nothing = VoxelTree::build({.depth = 5});
    const TestBeam beam({1.0, 2.0, 3.0}, {0.0, 0.0, 1.0}, 0.1, 0.01);
    EXPECT_TRUE(start_list(nothing, beam.beam).nodes.empty());
    VoxelCloud one{.depth = 5};
    one.voxels.push_back(make_voxel({10, 10, 10}, pack_rgb(Rgb(1.0f))));
    const VoxelTree tree = VoxelTree::build(std::move(one));
    EXPECT_TRUE(start_list(tree, TestBeam({10.5, 10.5, 20.0}, {0.0, 0.0, 1.0}, 0.1, 0.0).beam)
                    .nodes.empty())
        << "behind the beam";
    const StartList found =
        start_list(tree, TestBeam({10.5, 10.5, 0.0}, {0.0, 0.0, 1.0}, 0.1, 0.0).beam);
    ASSERT_EQ(found.nodes.size(), 1u);
    EXPECT_EQ(found.nodes[0].level, 2);
    EXPECT_EQ(found.steps, 3u) << "levels 4, 3, 2";
}

}  // namespace
}  // namespace probebake
