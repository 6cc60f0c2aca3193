#include "octree/walk.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/ray_families.h"

namespace probebake {
namespace {

constexpr double kSide = 16.0;
constexpr int kRaysPerFamily = 900;
constexpr OctreeTraversal kWalks[] = {OctreeTraversal::kFromRoot, OctreeTraversal::kFromAncestor,
                                      OctreeTraversal::kTopDown};

struct Leaf {
    Box box;
    OctreeRef ref;
    std::vector<uint32_t> path;  // octants from the root
};

/// A tree over [0, 16]³ split at random down to random depths, and the list of its leaves.
struct TestTree {
    Octree tree{Box{Vec3(0.0), Vec3(kSide)}};
    std::vector<Leaf> leaves;
    uint32_t named = 0;

    enum class Planes { kCenter, kAnywhere, kOnFaces };

    TestTree(uint64_t seed, Planes planes, int max_depth) {
        RandomStream random(random_key({seed}));
        tree.set_root(build(random, planes, tree.box(), max_depth, {}));
    }

    OctreeRef build(RandomStream& random, Planes planes, const Box& box, int depth,
                    const std::vector<uint32_t>& path) {
        if (depth == 0 || (!path.empty() && random.below(3) == 0)) {
            const OctreeRef ref =
                random.below(4) == 0 ? OctreeRef::empty_leaf() : OctreeRef::leaf(named++);
            leaves.push_back({box, ref, path});
            return ref;
        }
        Vec3 at = 0.5 * (box.low + box.high);
        if (planes != Planes::kCenter) {
            for (int axis = 0; axis < 3; ++axis) {
                at[axis] = box.low[axis] + random.uniform() * (box.high[axis] - box.low[axis]);
            }
        }
        // A plane on a face makes octants without extent.
        if (planes == Planes::kOnFaces && random.below(3) == 0) at.x = box.low.x;
        if (planes == Planes::kOnFaces && random.below(3) == 0) at.y = box.high.y;
        const OctreeRef ref = tree.add_node(at);
        for (int octant = 0; octant < 8; ++octant) {
            std::vector<uint32_t> below = path;
            below.push_back(static_cast<uint32_t>(octant));
            tree.set_child(ref, octant,
                           build(random, planes, octant_box(box, at, octant), depth - 1, below));
        }
        return ref;
    }
};

struct Shown {
    uint32_t leaf;
    double in;
    double out;
    bool operator==(const Shown&) const = default;
};

struct Expected {
    std::vector<Shown> shown;
    WalkCounts from_root;
    WalkCounts from_ancestor;
    WalkCounts top_down;
};

size_t common(const std::vector<uint32_t>& a, const std::vector<uint32_t>& b) {
    return static_cast<size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first -
                               a.begin());
}

/// Every leaf's own interval of t, in order; what the walks visit follows from the leaves' paths.
Expected brute_force(const TestTree& test, const Ray& ray, const TRange& range) {
    const OctreeRay octree_ray(ray);
    struct Met {
        double in;
        double out;
        const Leaf* leaf;
    };
    std::vector<Met> met;
    for (const Leaf& leaf : test.leaves) {
        const Vec3 near = octree_ray.t_near(leaf.box);
        const double in = std::max({near.x, near.y, near.z, range.begin});
        const double out = least(octree_ray.t_far(leaf.box));
        if (in < out && in < range.end) met.push_back({in, out, &leaf});
    }
    std::sort(met.begin(), met.end(), [](const Met& a, const Met& b) { return a.in < b.in; });
    Expected expected;
    const Leaf* previous = nullptr;
    for (const Met& m : met) {
        const size_t depth = m.leaf->path.size();
        const size_t shared = previous == nullptr ? 0 : common(previous->path, m.leaf->path);
        for (WalkCounts* counts :
             {&expected.from_root, &expected.from_ancestor, &expected.top_down}) {
            ++counts->leaves;
            if (m.leaf->ref.is_empty()) ++counts->empty_leaves;
        }
        expected.from_root.steps += depth + 1;
        if (previous == nullptr) {
            expected.from_ancestor.steps += depth + 1;
            expected.top_down.steps += depth + 1;
        } else {
            expected.from_ancestor.steps += (previous->path.size() - shared) + (depth - shared);
            expected.top_down.steps += depth - shared;
        }
        if (!m.leaf->ref.is_empty()) expected.shown.push_back({m.leaf->ref.number(), m.in, m.out});
        previous = m.leaf;
    }
    // Out of the box: up to the root. Out of the range: no further.
    if (previous != nullptr && met.back().out < range.end) {
        expected.from_ancestor.steps += previous->path.size();
    }
    return expected;
}

void expect_counts(const WalkCounts& got, const WalkCounts& expected, const std::string& what) {
    ASSERT_EQ(got.steps, expected.steps) << what;
    ASSERT_EQ(got.leaves, expected.leaves) << what;
    ASSERT_EQ(got.empty_leaves, expected.empty_leaves) << what;
}

TEST(OctreeWalk, EveryWalkShowsTheLeavesOfBruteForceOnEveryRayFamily) {
    const TestTree trees[] = {{1, TestTree::Planes::kCenter, 4},
                              {2, TestTree::Planes::kAnywhere, 3},
                              {3, TestTree::Planes::kOnFaces, 3},
                              {4, TestTree::Planes::kCenter, 0}};
    constexpr TRange kRanges[] = {{}, {.begin = 3.0, .end = 21.5}, {.begin = -1e9, .end = 1e12}};
    uint64_t shown = 0;
    for (const TestTree& test : trees) {
        uint64_t family_index = 0;
        for (const test::RayFamily& family : test::ray_families()) {
            RandomStream random(random_key({5, family_index++}));
            if (!family.well_defined) continue;
            for (int i = 0; i < kRaysPerFamily; ++i) {
                const Ray ray = family.make(random, kSide);
                const TRange range = kRanges[static_cast<size_t>(i) % std::size(kRanges)];
                const Expected expected = brute_force(test, ray, range);
                for (const OctreeTraversal how : kWalks) {
                    const std::string what = family.name + ", ray " + std::to_string(i) +
                                             ", walk " + std::to_string(static_cast<int>(how));
                    WalkCounts counts;
                    std::vector<Shown> got;
                    walk(test.tree, how, ray, range, counts,
                         [&](uint32_t leaf, double in, double out) {
                             got.push_back({leaf, in, out});
                             return false;
                         });
                    ASSERT_EQ(got, expected.shown) << what;
                    ASSERT_NO_FATAL_FAILURE(expect_counts(
                        counts,
                        how == OctreeTraversal::kFromRoot       ? expected.from_root
                        : how == OctreeTraversal::kFromAncestor ? expected.from_ancestor
                                                                : expected.top_down,
                        what));
                    shown += got.size();
                }
            }
        }
    }
    EXPECT_GT(shown, 200000u);
}

TEST(OctreeWalk, EndsWhereTheVisitorSaysSo) {
    const TestTree test(6, TestTree::Planes::kCenter, 3);
    RandomStream random(7);
    for (int i = 0; i < 200; ++i) {
        const Ray ray = test::towards(random, test::random_point(random, kSide), 40.0);
        const Expected expected = brute_force(test, ray, {});
        if (expected.shown.size() < 2) continue;
        for (const OctreeTraversal how : kWalks) {
            WalkCounts counts;
            size_t calls = 0;
            walk(test.tree, how, ray, {}, counts,
                 [&](uint32_t, double, double) { return ++calls == 2; });
            ASSERT_EQ(calls, 2u);
        }
    }
}

TEST(OctreeRef, TellsNodesLeavesAndEmptyLeavesApart) {
    EXPECT_TRUE(OctreeRef().is_empty());
    EXPECT_TRUE(OctreeRef::empty_leaf().is_leaf());
    EXPECT_FALSE(OctreeRef::leaf(7).is_empty());
    EXPECT_EQ(OctreeRef::leaf(7).number(), 7u);
    EXPECT_FALSE(OctreeRef::node(7).is_leaf());
    EXPECT_EQ(OctreeRef::node(7).number(), 7u);
}

}  // namespace
}  // namespace probebake
