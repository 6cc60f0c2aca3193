#include "octree/item_octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "support/ray_families.h"

namespace probebake {
namespace {

constexpr double kSide = 16.0;
const Box kRoot{Vec3(0.0), Vec3(kSide)};

std::vector<Box> random_boxes(uint64_t seed, int count) {
    RandomStream random(random_key({seed}));
    std::vector<Box> boxes;
    for (int i = 0; i < count; ++i) {
        const Vec3 low = test::random_point(random, kSide - 1.0);
        boxes.push_back({low, low + test::random_point(random, 1.0)});
    }
    return boxes;
}

/// Every leaf with its box and depth.
template <class Visit>
void for_each_leaf(const ItemOctree& octree, OctreeRef ref, const Box& box, int depth,
                   Visit visit) {
    if (ref.is_leaf()) {
        visit(ref, box, depth);
        return;
    }
    const Octree::Node& node = octree.tree().node(ref);
    for (int octant = 0; octant < 8; ++octant) {
        for_each_leaf(octree, node.children[static_cast<size_t>(octant)],
                      octant_box(box, node.planes, octant), depth + 1, visit);
    }
}

TEST(ItemOctree, ALeafNamesEveryItemThatTouchesItAndNoOther) {
    const std::vector<Box> boxes = random_boxes(1, 120);
    for (const SplitPlanes planes : {SplitPlanes::kCenter, SplitPlanes::kCostEstimate}) {
        const ItemOctree octree(kRoot, boxes, {.max_depth = 4, .planes = planes});
        ItemOctreeCounts counts{.inner = octree.tree().nodes().size()};
        for_each_leaf(octree, octree.tree().root(), kRoot, 0,
                      [&](OctreeRef leaf, const Box& box, int depth) {
                          std::vector<uint32_t> expected;
                          for (uint32_t i = 0; i < boxes.size(); ++i) {
                              if (overlap_closed(boxes[i], box)) expected.push_back(i);
                          }
                          std::vector<uint32_t> got;
                          if (!leaf.is_empty()) {
                              const auto items = octree.items(leaf.number());
                              got.assign(items.begin(), items.end());
                          }
                          ASSERT_EQ(got, expected);
                          ASSERT_TRUE(got.size() <= 1 || depth == 4);
                          ++counts.leaves;
                          counts.empty_leaves += got.empty() ? 1 : 0;
                          counts.references += got.size();
                      });
        EXPECT_EQ(octree.counts(), counts);
        EXPECT_EQ(counts.leaves, 7 * counts.inner + 1);
        EXPECT_GT(counts.inner, 20u);
        EXPECT_GT(counts.empty_leaves, 100u);
    }
}

TEST(ItemOctree, OctantsAreClosedOnBothSides) {
    const std::vector<Box> boxes = {{Vec3(8.0), Vec3(8.0)}, {Vec3(1.0), Vec3(1.0)}};
    const ItemOctree octree(kRoot, boxes, {.max_depth = 1});
    EXPECT_EQ(octree.counts().references, 8u + 1u);  // a point in the middle is in all eight
    EXPECT_EQ(octree.counts().empty_leaves, 0u);
}

TEST(ItemOctree, OneItemOrNoneIsALeaf) {
    const ItemOctree none(kRoot, {}, {});
    EXPECT_TRUE(none.tree().root().is_empty());
    EXPECT_EQ(none.counts(), (ItemOctreeCounts{.leaves = 1, .empty_leaves = 1}));
    const std::vector<Box> one = {kRoot};
    EXPECT_EQ(ItemOctree(kRoot, one, {}).counts(),
              (ItemOctreeCounts{.leaves = 1, .references = 1}));
}

TEST(ItemOctree, AReferenceLimitEndsTheSplitting) {
    const std::vector<Box> all_over(100, kRoot);
    const ItemOctree octree(kRoot, all_over, {.max_depth = 20, .most_references = 100000});
    EXPECT_LE(octree.counts().references, 200000u);
}

TEST(ItemOctree, RefusesWhatItCannotBuild) {
    const std::vector<Box> bad = {{Vec3(0.0), Vec3(std::nan(""))}};
    EXPECT_THROW(ItemOctree(kRoot, bad, {}), std::invalid_argument);
    EXPECT_THROW(ItemOctree(kRoot, {}, {.max_depth = kMaxOctreeDepth + 1}), std::invalid_argument);
    EXPECT_THROW(ItemOctree(kRoot, {}, {.max_depth = -1}), std::invalid_argument);
}

}  // namespace
}  // namespace probebake
