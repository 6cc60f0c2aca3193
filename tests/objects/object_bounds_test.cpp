#include "objects/object_bounds.h"

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

#include "objects/object_octree.h"
#include "objects/object_worlds.h"

namespace probebake {
namespace {

void expect_box(const Box& got, const Vec3& low, const Vec3& high) {
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(got.low[axis], low[axis], 1e-12) << axis;
        EXPECT_NEAR(got.high[axis], high[axis], 1e-12) << axis;
    }
}

TEST(ObjectBox, IsTight) {
    ObjectSet set;
    set.add(Sphere{Vec3(1.0, 2.0, 3.0), 0.5});
    set.add(Cone{Vec3(0.0), 2.0, Vec3(0.0, 0.0, 5.0), 1.0});
    set.add(Cone{Vec3(0.0), 1.0, Vec3(1.0, 1.0, 0.0), 1.0});
    set.add(Triangle{Vec3(0.0), Vec3(1.0, -2.0, 0.0), Vec3(0.0, 3.0, 4.0)});
    expect_box(object_box(set, 0), Vec3(0.5, 1.5, 2.5), Vec3(1.5, 2.5, 3.5));
    expect_box(object_box(set, 1), Vec3(-2.0, -2.0, 0.0), Vec3(2.0, 2.0, 5.0));
    const double spread = std::sqrt(0.5);  // sqrt(1 − 1/2)
    expect_box(object_box(set, 2), Vec3(-spread, -spread, -1.0),
               Vec3(1.0 + spread, 1.0 + spread, 1.0));
    expect_box(object_box(set, 3), Vec3(0.0, -2.0, 0.0), Vec3(1.0, 3.0, 4.0));
}

TEST(ObjectBox, HoldsWhatASampledConeReaches) {
    RandomStream random(1);
    for (int i = 0; i < 200; ++i) {
        ObjectSet set;
        const Vec3 base = test::place(random);
        const Vec3 axis = test::random_direction(random);
        const Cone cone{base, random.uniform(), base + axis * (0.1 + random.uniform()),
                        random.uniform()};
        set.add(cone);
        const Box box = object_box(set, 0);
        Box reached = empty_box();
        const Vec3 u = glm::normalize(
            glm::cross(axis, std::abs(axis.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
        const Vec3 v = glm::cross(axis, u);
        constexpr int kAngles = 2000;
        for (int k = 0; k < kAngles; ++k) {
            const double angle = 2 * 3.14159265358979 * k / kAngles;
            const Vec3 out = std::cos(angle) * u + std::sin(angle) * v;
            reached = join(reached, cone.base + cone.base_radius * out);
            reached = join(reached, cone.apex + cone.apex_radius * out);
        }
        for (int a = 0; a < 3; ++a) {
            EXPECT_NEAR(box.low[a], reached.low[a], 1e-5);
            EXPECT_NEAR(box.high[a], reached.high[a], 1e-5);
            EXPECT_LE(box.low[a], reached.low[a] + 1e-12);
            EXPECT_GE(box.high[a], reached.high[a] - 1e-12);
        }
    }
}

TEST(ObjectBox1999, WidensThinPolygonsAndScalesCones) {
    ObjectSet set;
    set.add_polygon(std::vector<Vec3>{Vec3(0.0, 0.0, 5.0), Vec3(1.0, 0.0, 5.0), Vec3(1.0, 1.0, 5.0),
                                      Vec3(0.0, 1.0, 5.0)});
    set.add(Cone{Vec3(-10.0, 0.0, 10.0), 1.0, Vec3(-10.0, 0.0, 12.0), 1.0});
    set.add(Sphere{Vec3(-10.0), 1.0});
    expect_box(object_box_1999(set, 0), Vec3(0.0, 0.0, 4.98), Vec3(1.0, 1.0, 5.02));
    expect_box(object_box_1999(set, 1), Vec3(-10.989, -0.999, 9.99), Vec3(-9.009, 1.001, 12.012));
    expect_box(object_box_1999(set, 2), Vec3(-11.0), Vec3(-9.0));
    const ObjectBoxes boxes = boxes_1999(set);
    expect_box(boxes.root, Vec3(-11.001, -11.001, -11.001), Vec3(1.001, 1.002, 12.013));
}

TEST(SafeBoxes, AreWiderThanTheirObjects) {
    for (const test::ObjectWorld& world : test::object_worlds()) {
        const ObjectBoxes boxes = safe_boxes(world.set);
        for (uint32_t i = 0; i < world.set.size(); ++i) {
            const Box tight = object_box(world.set, i);
            for (int a = 0; a < 3; ++a) {
                ASSERT_LT(boxes.boxes[i].low[a], tight.low[a]);
                ASSERT_GT(boxes.boxes[i].high[a], tight.high[a]);
                ASSERT_LT(boxes.root.low[a], boxes.boxes[i].low[a]);
                ASSERT_GT(boxes.root.high[a], boxes.boxes[i].high[a]);
            }
        }
    }
}

TEST(SafeBoxes, HoldWhereAWarpedPolygonIsHit) {
    ObjectSet set;
    const std::array<Vec3, 8> vertices = {Vec3(0, 0, 1), Vec3(3, 0, 1), Vec3(3, 3, 3),
                                          Vec3(2, 3, 1), Vec3(2, 1, 1), Vec3(1, 1, 1),
                                          Vec3(1, 3, 1), Vec3(0, 3, 1)};
    set.add_polygon(vertices);
    const Box box = safe_boxes(set).boxes[0];
    const Box of_vertices = object_box(set, 0);
    int below_all_vertices = 0;
    for (int i = 0; i < 400; ++i) {
        const int row = i / 20;
        const Vec3 origin(3.0 * (i % 20) / 19.0, 3.0 * row / 19.0, 10.0);
        const ObjectHit hit =
            closest_hit_of_all(set, {Vec3(-20.0), Vec3(20.0)}, {origin, Vec3(0.0, 0.0, -1.0)});
        if (!hit) continue;
        const double z = origin.z - hit.t;
        EXPECT_GE(z, box.low.z);
        EXPECT_LE(z, box.high.z);
        below_all_vertices += z < of_vertices.low.z - 0.01 ? 1 : 0;
    }
    EXPECT_GT(below_all_vertices, 0) << "or the test shows nothing";
}

TEST(ObjectSet, RefusesWhatIsNoShape) {
    ObjectSet set;
    const double nan = std::nan("");
    EXPECT_THROW(set.add(Sphere{Vec3(0.0), -1.0}), std::invalid_argument);
    EXPECT_THROW(set.add(Sphere{Vec3(nan), 1.0}), std::invalid_argument);
    EXPECT_THROW(set.add(Cone{Vec3(1.0), 1.0, Vec3(1.0), 1.0}), std::invalid_argument);
    EXPECT_THROW(set.add(Cone{Vec3(1.0), nan, Vec3(2.0), 1.0}), std::invalid_argument);
    EXPECT_THROW(set.add(Triangle{Vec3(nan), Vec3(0.0), Vec3(0.0)}), std::invalid_argument);
    EXPECT_THROW(set.add_polygon(std::vector<Vec3>(2)), std::invalid_argument);
    EXPECT_EQ(set.size(), 0u);
}

}  // namespace
}  // namespace probebake
