#include "objects/object_octree.h"

#include <gtest/gtest.h>

#include "objects/object_worlds.h"

namespace probebake {
namespace {

using test::kWorldSide;

constexpr int kRaysPerFamily = 1800;
constexpr OctreeTraversal kWalks[] = {OctreeTraversal::kFromRoot, OctreeTraversal::kFromAncestor,
                                      OctreeTraversal::kTopDown};

TEST(ObjectOctree, AgreesWithBruteForceOnEveryRayFamily) {
    for (const test::ObjectWorld& world : test::object_worlds()) {
        const ObjectBoxes boxes = world.boxes();
        const ObjectOctree octrees[] = {
            {world.set, boxes, {.max_depth = 4}},
            {world.set, boxes, {.max_depth = 4, .planes = SplitPlanes::kCostEstimate}}};
        int hits = 0;
        uint64_t family_index = 0;
        for (const test::RayFamily& family : test::ray_families()) {
            RandomStream random(random_key({8, family_index++}));
            for (int i = 0; i < kRaysPerFamily; ++i) {
                const Ray ray = family.make(random, kWorldSide);
                const double length = glm::length(ray.direction);
                const TRange range = i % 3 == 0 ? TRange{2.0 / length, 25.0 / length} : TRange{};
                const ObjectHit expected =
                    family.well_defined ? closest_hit_of_all(world.set, boxes.root, ray, range)
                                        : ObjectHit{};
                hits += expected ? 1 : 0;
                for (const ObjectOctree& octree : octrees) {
                    for (const OctreeTraversal how : kWalks) {
                        const auto what = [&] {
                            return world.name + ", " + family.name + ", ray " + std::to_string(i) +
                                   ", walk " + std::to_string(static_cast<int>(how));
                        };
                        CastCounts counts;
                        const ObjectHit got = octree.closest_hit(ray, range, how, counts);
                        ASSERT_EQ(got.object, expected.object) << what();
                        ASSERT_EQ(got.t, expected.t) << what();
                        if (how != kWalks[static_cast<size_t>(i) % std::size(kWalks)]) continue;
                        const ObjectHit any = octree.any_hit(ray, range, how, counts);
                        ASSERT_EQ(static_cast<bool>(any), static_cast<bool>(expected)) << what();
                        ASSERT_GE(any.t, expected.t) << what();
                    }
                }
            }
        }
        EXPECT_GT(hits, 2000) << world.name;
    }
}

TEST(ObjectOctree, TheBoxThatRaysAreBroughtToDoesNotMatter) {
    // The root of safe_boxes instead of one made for the rays: other local rays, the same hits.
    for (const test::ObjectWorld& world : test::object_worlds()) {
        const ObjectOctree octree(world.set, safe_boxes(world.set), {.max_depth = 6});
        const Box wide{Vec3(-100.0), Vec3(120.0)};
        RandomStream random(9);
        int compared = 0;
        for (int i = 0; i < 2000; ++i) {
            const Ray ray =
                test::towards(random, test::random_point(random, kWorldSide), 2 * kWorldSide);
            const ObjectHit got = octree.closest_hit(ray);
            const ObjectHit expected = closest_hit_of_all(world.set, wide, ray);
            // Objects that coincide may change places.
            ASSERT_EQ(static_cast<bool>(got), static_cast<bool>(expected))
                << world.name << ", ray " << i;
            if (!expected) continue;
            ASSERT_NEAR(got.t, expected.t, 1e-9) << world.name << ", ray " << i;
            ++compared;
        }
        EXPECT_GT(compared, 200) << world.name;
    }
}

TEST(ObjectOctree, CountsEveryTestOfEveryLeaf) {
    ObjectSet set;
    set.add(Sphere{Vec3(4.0, 8.0, 8.0), 1.0});  // across the middle planes of y and z
    set.add(Sphere{Vec3(12.0, 8.0, 8.0), 1.0});
    const ObjectBoxes boxes{{Vec3(0.0), Vec3(16.0)}, {object_box(set, 0), object_box(set, 1)}};
    const ObjectOctree octree(set, boxes, {.max_depth = 1});
    CastCounts counts;
    const ObjectHit hit = octree.closest_hit({Vec3(-1.0, 7.5, 8.5), Vec3(1.0, 0.0, 0.0)}, {},
                                             OctreeTraversal::kTopDown, counts);
    EXPECT_EQ(hit.object, 0u);
    EXPECT_EQ(counts.tests, 1u);  // it ends in the first leaf
    EXPECT_EQ(counts.walk.steps, 2u);
    CastCounts past;
    EXPECT_EQ(octree
                  .closest_hit({Vec3(-1.0, 6.5, 7.0), Vec3(1.0, 0.0, 0.0)}, {},
                               OctreeTraversal::kTopDown, past)
                  .object,
              ObjectHit::kNone);
    EXPECT_EQ(past.tests, 2u);
    EXPECT_EQ(past.walk.leaves, 2u);
}

TEST(ObjectOctree, OfEqualHitsTheLowestNumberCounts) {
    ObjectSet set;
    for (int i = 0; i < 3; ++i) set.add(Sphere{Vec3(0.0), 1.0});
    const ObjectOctree octree(set, safe_boxes(set), {.max_depth = 3});
    const ObjectHit hit = octree.closest_hit({Vec3(0.1, 0.2, -5.0), Vec3(0.0, 0.0, 1.0)});
    EXPECT_EQ(hit.object, 0u);
}

TEST(ObjectOctree, AnEmptySetIsMissed) {
    const ObjectSet set;
    const ObjectOctree octree(set, safe_boxes(set), {});
    EXPECT_FALSE(octree.closest_hit({Vec3(-1.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0)}));
}

TEST(ObjectOctree, TheBoxesOf1999LoseHitsOnTheNegativeSide) {
    // Why they are for the comparison only: at x = −1000 the signed scaling cuts 1 off the boxes.
    ObjectSet set;
    RandomStream random(10);
    for (int i = 0; i < 50; ++i) {
        const Vec3 base = test::random_point(random, 20.0) - Vec3(1000.0);
        set.add(Cone{base, 0.4, base + test::random_direction(random), 0.4});
    }
    const ObjectOctree safe(set, safe_boxes(set), {.max_depth = 6});
    ObjectBoxes boxes = boxes_1999(set);
    boxes.root = safe_boxes(set).root;
    const ObjectOctree lossy(set, boxes, {.max_depth = 6});
    int lost = 0;
    for (int i = 0; i < 2000; ++i) {
        const Ray ray =
            test::towards(random, test::random_point(random, 20.0) - Vec3(1000.0), 60.0);
        const ObjectHit hit = safe.closest_hit(ray);
        ASSERT_EQ(hit.object, closest_hit_of_all(set, boxes.root, ray).object);
        if (lossy.closest_hit(ray).object != hit.object) ++lost;
    }
    EXPECT_GT(lost, 20);
}

}  // namespace
}  // namespace probebake
