#include "mesh/triangle_box.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <functional>
#include <string>
#include <vector>

#include "math/random.h"

namespace probebake {
namespace {

using Rational = boost::multiprecision::cpp_rational;
using Point = std::array<Rational, 3>;
using Corners = std::array<IVec3, 3>;

/// Clips the triangle against the six half-spaces of the box in rational numbers: they meet where
/// something is left, were it a point.
bool overlap_by_clipping(const Corners& triangle, const IVec3& low, int edge) {
    std::vector<Point> polygon;
    for (const IVec3& v : triangle) polygon.push_back({Rational(v.x), v.y, v.z});
    for (size_t axis = 0; axis < 3; ++axis) {
        for (const int side : {1, -1}) {
            const int plane = low[static_cast<int>(axis)] + (side > 0 ? 0 : edge);
            const auto depth = [&](const Point& p) -> Rational { return (p[axis] - plane) * side; };
            std::vector<Point> kept;
            for (size_t i = 0; i < polygon.size(); ++i) {
                const Point& a = polygon[i];
                const Point& b = polygon[(i + 1) % polygon.size()];
                const Rational da = depth(a);
                const Rational db = depth(b);
                if (da >= 0) kept.push_back(a);
                if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
                    const Rational t = da / (da - db);
                    Point cut;
                    for (size_t k = 0; k < 3; ++k) cut[k] = a[k] + (b[k] - a[k]) * t;
                    kept.push_back(cut);
                }
            }
            polygon = std::move(kept);
        }
    }
    return !polygon.empty();
}

struct Family {
    std::string name;
    std::function<Corners(RandomStream&)> make;
};

int coordinate(RandomStream& random, int64_t range) {
    return static_cast<int>(random.below(static_cast<uint64_t>(range) + 1));
}
IVec3 vertex(RandomStream& random, int64_t range) {
    return {coordinate(random, range), coordinate(random, range), coordinate(random, range)};
}

/// Around the box [8, 16]³ of a space [0, 24]³, times a scale.
std::vector<Family> families(int scale) {
    const int range = 24 * scale;
    const auto on_planes = [scale](RandomStream& r) { return vertex(r, 6) * (4 * scale); };
    return {{"generic",
             [=](RandomStream& r) {
                 return Corners{vertex(r, range), vertex(r, range), vertex(r, range)};
             }},
            {"on grid planes",
             [=](RandomStream& r) {
                 return Corners{on_planes(r), on_planes(r), on_planes(r)};
             }},
            {"in a grid plane",
             [=](RandomStream& r) {
                 Corners c{vertex(r, range), vertex(r, range), vertex(r, range)};
                 const int axis = static_cast<int>(r.below(3));
                 const int plane = on_planes(r)[axis];
                 for (IVec3& v : c) v[axis] = plane;
                 return c;
             }},
            {"slivers",
             [=](RandomStream& r) {
                 const IVec3 a = vertex(r, range - 1);
                 return Corners{a, vertex(r, range), a + vertex(r, 1)};
             }},
            {"segments",
             [=](RandomStream& r) {
                 const IVec3 a = vertex(r, range / 2);
                 const IVec3 b = vertex(r, range / 2);
                 return Corners{a, b, 2 * b - a};
             }},
            {"doubled segments",
             [=](RandomStream& r) {
                 const IVec3 a = on_planes(r);
                 return Corners{a, on_planes(r), a};
             }},
            {"points",
             [=](RandomStream& r) {
                 const IVec3 a = on_planes(r);
                 return Corners{a, a, a};
             }},
            // A plane through a corner of the box: what one unit decides.
            {"touching a corner", [=](RandomStream& r) {
                 const IVec3 corner = IVec3(8 * scale) + vertex(r, 1) * (8 * scale);
                 const IVec3 a = vertex(r, range);
                 const IVec3 b = vertex(r, range);
                 IVec3 c = 2 * corner - a;
                 for (int k = 0; k < 3; ++k) c[k] = std::clamp(c[k], 0, range);
                 if (r.below(2) == 0) c[static_cast<int>(r.below(3))] ^= 1;
                 return Corners{a, b, c};
             }}};
}

/// Coordinates up to `scale` · 24; both answers have to come up.
void compare(int scale, int count) {
    for (const Family& family : families(scale)) {
        RandomStream random(
            random_key({0x626F78, static_cast<uint64_t>(scale), family.name.size()}));
        int met = 0;
        for (int i = 0; i < count; ++i) {
            const Corners c = family.make(random);
            const bool expected = overlap_by_clipping(c, IVec3(8 * scale), 8 * scale);
            met += expected ? 1 : 0;
            ASSERT_EQ(TriangleBox(c).overlaps(IVec3(8 * scale), 8 * scale), expected)
                << family.name << " of scale " << scale << ", triangle " << i;
        }
        EXPECT_GT(met, 0) << family.name;
        EXPECT_LT(met, count) << family.name;
    }
}

TEST(TriangleBox, AgreesWithRationalClippingOnSmallNumbers) { compare(1, 1200); }

TEST(TriangleBox, AgreesWithRationalClippingOnTheLargestNumbers) {
    compare(static_cast<int>(kMostGridUnits / 24), 1200);
}

TEST(TriangleBox, OneUnitDecides) {
    // The plane x + y + z = 3 · 2^27 + d cuts off the box's far corner, touches it or misses it.
    const int half = 1 << 27;
    for (const int d : {-1, 0, 1}) {
        const int sum = 3 * half + d;
        const int most = 1 << 28;
        const Corners c{IVec3(most, sum - most, 0), IVec3(0, most, sum - most),
                        IVec3(sum - most, 0, most)};
        EXPECT_EQ(TriangleBox(c).overlaps(IVec3(0), half), d <= 0) << d;
        EXPECT_EQ(TriangleBox(c).overlaps(IVec3(half), half), d >= 0) << d;
    }
}

TEST(TriangleBox, WhatLiesOnAPlaneBelongsToBothSides) {
    const Corners face{IVec3(0, 8, 0), IVec3(8, 8, 0), IVec3(0, 8, 8)};
    EXPECT_TRUE(TriangleBox(face).overlaps(IVec3(0, 0, 0), 8));
    EXPECT_TRUE(TriangleBox(face).overlaps(IVec3(0, 8, 0), 8));
    EXPECT_FALSE(TriangleBox(face).overlaps(IVec3(0, 9, 0), 8));
    // Its long edge touches the box across the diagonal in the corner (8, 8, 0) no more.
    EXPECT_TRUE(TriangleBox(face).overlaps(IVec3(8, 8, 0), 8));
    EXPECT_TRUE(TriangleBox(face).overlaps(IVec3(4, 8, 4), 8));
    EXPECT_FALSE(TriangleBox(face).overlaps(IVec3(5, 8, 4), 8));
}

}  // namespace
}  // namespace probebake
