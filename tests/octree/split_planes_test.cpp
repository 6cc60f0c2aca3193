#include "octree/split_planes.h"

#include <gtest/gtest.h>

namespace probebake {
namespace {

constexpr AxisInterval kSide{0.0, 10.0};

TEST(SplitCost, IsTheFormulaOfHavran1999) {
    // a = 10, b = 2, c = 3. One item left of 4, two right, one across:
    // (1 + 1) (2·4·5 + 6) + (2 + 1) (2·6·5 + 6) = 2·46 + 3·66.
    const AxisInterval items[] = {{0.0, 3.0}, {5.0, 6.0}, {7.0, 9.0}, {3.5, 4.5}};
    EXPECT_EQ(split_cost(items, kSide, 4.0, 2.0, 3.0), 2 * 46.0 + 3 * 66.0);
}

TEST(SplitCost, ItemsThatTouchThePlaneAreNotCut) {
    const AxisInterval items[] = {{0.0, 4.0}, {4.0, 9.0}, {4.0, 4.0}};
    // Left: the one that ends there and the one within; right: the one that begins there.
    EXPECT_EQ(split_cost(items, kSide, 4.0, 2.0, 3.0), 2 * 46.0 + 1 * 66.0);
}

TEST(SplitCost, LiesOnTheSideDescribedByTheBoxNotByZero) {
    const AxisInterval items[] = {{100.0, 103.0}, {105.0, 106.0}, {107.0, 109.0}, {103.5, 104.5}};
    EXPECT_EQ(split_cost(items, {100.0, 110.0}, 104.0, 2.0, 3.0), 2 * 46.0 + 3 * 66.0);
}

TEST(CostPlanes, MoveTowardsTheItemsWhereThatIsCheaper) {
    // Four small items at the low end of x: the mean of their centres is 1, the middle 5, so the
    // ten positions are 5, 4.6, … 1.4. All items are left of any of them down to 1.8, so the
    // cheapest is the lowest of those that cut none.
    const Box box{Vec3(0.0), Vec3(10.0)};
    std::vector<Box> boxes;
    for (const double x : {0.6, 0.8, 1.2, 1.4}) {
        boxes.push_back({Vec3(x - 0.1, 4.0, 4.0), Vec3(x + 0.1, 6.0, 6.0)});
    }
    const std::vector<uint32_t> items = {0, 1, 2, 3};
    const Vec3 planes = cost_planes(box, items, boxes);
    EXPECT_NEAR(planes.x, 1.8, 1e-12);
    EXPECT_EQ(planes.y, 5.0);  // every position cuts all four: the first of equals, the middle
    EXPECT_EQ(planes.z, 5.0);
}

TEST(CostPlanes, TheMedianIsOfWhatLiesInTheBox) {
    // An item that reaches far out of the box counts with its part inside: centre 5, not 500.
    const Box box{Vec3(0.0), Vec3(10.0)};
    const std::vector<Box> boxes = {{Vec3(0.0), Vec3(1000.0, 1.0, 1.0)}};
    const std::vector<uint32_t> items = {0};
    EXPECT_EQ(cost_planes(box, items, boxes).x, 5.0);
}

TEST(CostPlanes, StayInTheBox) {
    const Box box{Vec3(0.0), Vec3(10.0)};
    const std::vector<Box> boxes = {{Vec3(20.0), Vec3(30.0)}, {Vec3(-9.0), Vec3(-8.0)}};
    for (const std::vector<uint32_t>& items :
         {std::vector<uint32_t>{0}, std::vector<uint32_t>{1}, std::vector<uint32_t>{0, 1}}) {
        const Vec3 planes = cost_planes(box, items, boxes);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_GE(planes[axis], 0.0);
            EXPECT_LE(planes[axis], 10.0);
        }
    }
}

TEST(CenterPlanes, AreTheMiddle) {
    EXPECT_EQ(center_planes({Vec3(1.0, 2.0, 3.0), Vec3(3.0, 6.0, 9.0)}), Vec3(2.0, 4.0, 6.0));
}

}  // namespace
}  // namespace probebake
