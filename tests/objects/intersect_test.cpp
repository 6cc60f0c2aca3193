#include "objects/intersect.h"

#include <gtest/gtest.h>

#include "objects/object_worlds.h"

namespace probebake {
namespace {

constexpr TRange kAll{-kInfinity, kInfinity};

Ray ray_to(const Vec3& from, const Vec3& to) { return {from, glm::normalize(to - from)}; }

TEST(IntersectSphere, FrontBackAndMiss) {
    const Sphere sphere{Vec3(0.0, 0.0, 5.0), 2.0};
    const PreparedRay ray({Vec3(0.0), Vec3(0.0, 0.0, 1.0)});
    EXPECT_EQ(intersect(sphere, ray, {}), 3.0);
    EXPECT_EQ(intersect(sphere, ray, {3.0, kInfinity}), 7.0);  // the range is open
    EXPECT_EQ(intersect(sphere, ray, {0.0, 3.0}), kInfinity);
    EXPECT_EQ(intersect(sphere, ray, {7.0, kInfinity}), kInfinity);
    EXPECT_EQ(intersect(sphere, PreparedRay({Vec3(0.0, 2.1, 0.0), Vec3(0.0, 0.0, 1.0)}), {}),
              kInfinity);
}

TEST(IntersectCone, IsOpenAndHasNoMirrorImage) {
    const Cone cone{Vec3(0.0), 2.0, Vec3(0.0, 0.0, 4.0), 1.0};
    // Radius at height z is 2 − z/4.
    EXPECT_NEAR(intersect(cone, PreparedRay({Vec3(-5.0, 0.0, 2.0), Vec3(1.0, 0.0, 0.0)}), {}), 3.5,
                1e-12);
    EXPECT_NEAR(intersect(cone, PreparedRay({Vec3(0.0, 0.0, 2.0), Vec3(1.0, 0.0, 0.0)}), {}), 1.5,
                1e-12);
    // Along the axis through both ends: no caps.
    EXPECT_EQ(intersect(cone, PreparedRay({Vec3(0.0, 0.0, -5.0), Vec3(0.0, 0.0, 1.0)}), {}),
              kInfinity);
    // Above the apex, where the same quadric goes on, and beyond its tip at z = 8.
    for (const double z : {4.5, 7.9, 9.0, -0.5}) {
        EXPECT_EQ(intersect(cone, PreparedRay({Vec3(-50.0, 0.0, z), Vec3(1.0, 0.0, 0.0)}), {}),
                  kInfinity)
            << z;
    }
}

TEST(IntersectCone, ARayAlongACylinderMeetsNothing) {
    // Rounding of the axis leaves a quadratic term of 1e-33: an absolute threshold would either
    // miss steep cones or report phantoms here.
    RandomStream random(2);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 axis = test::random_direction(random);
        const Vec3 base = test::place(random);
        const Cone cylinder{base, 1.0, base + 2.0 * axis, 1.0};
        const Vec3 aside = glm::normalize(glm::cross(axis, test::random_direction(random)));
        const double off = random.below(2) == 0 ? 0.5 : 1.5;
        const PreparedRay ray({base + off * aside - 20.0 * axis, axis});
        ASSERT_EQ(intersect(cylinder, ray, {}), kInfinity) << i;
    }
}

TEST(Intersect, HitsLieOnTheSurfaceAndNoneIsMissed) {
    // Aimed at a random point of each surface: there is a hit, at that point or before it, and it
    // lies on the surface.
    RandomStream random(3);
    for (int i = 0; i < 5000; ++i) {
        const Vec3 from = test::place(random) + 20.0 * test::random_direction(random);
        const Vec3 center = test::place(random);
        const Vec3 direction = test::random_direction(random);

        const Sphere sphere{center, 0.1 + random.uniform()};
        const Ray to_sphere = ray_to(from, center + sphere.radius * direction);
        const double t = intersect(sphere, PreparedRay(to_sphere), {});
        // A point on the silhouette may be missed by rounding alone.
        if (std::abs(glm::dot(to_sphere.direction, direction)) > 1e-4) {
            ASSERT_LT(t, kInfinity) << i;
            ASSERT_NEAR(glm::length(from + t * to_sphere.direction - center), sphere.radius, 1e-11);
            ASSERT_LE(t, glm::length(center + sphere.radius * direction - from) + 1e-9);
        }

        const double height = 0.2 + random.uniform();
        const Cone cone{center, random.uniform() + 0.1, center + height * direction,
                        random.uniform() + 0.1};
        const Vec3 out = glm::normalize(glm::cross(direction, test::random_direction(random)));
        const double share = 0.02 + 0.96 * random.uniform();
        const Vec3 on_cone =
            center + share * height * direction +
            (cone.base_radius + share * (cone.apex_radius - cone.base_radius)) * out;
        const Ray to_cone = ray_to(from, on_cone);
        ObjectSet set;
        set.add(cone);
        const Vec3 normal = normal_at(set, 0, on_cone);
        ASSERT_NEAR(glm::length(normal), 1.0, 1e-12);
        if (std::abs(glm::dot(to_cone.direction, normal)) > 1e-4) {
            const double s = intersect(cone, PreparedRay(to_cone), {});
            ASSERT_LT(s, kInfinity) << i;
            ASSERT_LE(s, glm::length(on_cone - from) + 1e-8) << i;
            const Vec3 at = from + s * to_cone.direction - center;
            const double along = glm::dot(at, direction);
            ASSERT_NEAR(glm::length(at - along * direction),
                        cone.base_radius + along / height * (cone.apex_radius - cone.base_radius),
                        1e-10);
            ASSERT_GE(along, -1e-12);
            ASSERT_LE(along, height + 1e-12);
        }
    }
}

TEST(IntersectTriangle, IsWatertightAtEdgesAndVertices) {
    // A fan around a vertex: rays to the vertex and to points of the inner edges meet one triangle
    // at least.
    RandomStream random(4);
    for (int i = 0; i < 3000; ++i) {
        const Vec3 tip = test::place(random);
        std::vector<Vec3> ring;
        constexpr int kParts = 6;
        for (int k = 0; k < kParts; ++k) {
            const double angle = 2 * 3.14159265358979 * k / kParts + random.uniform();
            ring.push_back(tip + Vec3(std::cos(angle), std::sin(angle), -random.uniform()));
        }
        const Vec3 from = tip + Vec3(random.uniform(), random.uniform(), 10.0 + random.uniform());
        const Vec3& neighbour = ring[random.below(kParts)];
        const double share = i % 2 == 0 ? 0.0 : 0.9 * random.uniform();
        const PreparedRay ray(ray_to(from, tip + share * (neighbour - tip)));
        double nearest = kInfinity;
        for (size_t k = 0; k < kParts; ++k) {
            nearest = std::min(nearest,
                               intersect(Triangle{tip, ring[k], ring[(k + 1) % kParts]}, ray, {}));
        }
        ASSERT_LT(nearest, kInfinity) << i;
    }
}

TEST(IntersectTriangle, FromBothSidesAndNeverEdgeOn) {
    const Triangle triangle{Vec3(0.0), Vec3(2.0, 0.0, 0.0), Vec3(0.0, 2.0, 0.0)};
    EXPECT_EQ(intersect(triangle, PreparedRay({Vec3(0.5, 0.5, 3.0), Vec3(0.0, 0.0, -1.0)}), {}),
              3.0);
    EXPECT_EQ(intersect(triangle, PreparedRay({Vec3(0.5, 0.5, -3.0), Vec3(0.0, 0.0, 1.0)}), {}),
              3.0);
    EXPECT_EQ(intersect(triangle, PreparedRay({Vec3(1.5, 1.5, -3.0), Vec3(0.0, 0.0, 1.0)}), {}),
              kInfinity);
    EXPECT_EQ(intersect(triangle, PreparedRay({Vec3(-3.0, 0.5, 0.0), Vec3(1.0, 0.0, 0.0)}), {}),
              kInfinity);
}

TEST(IntersectPolygon, FollowsAConcaveOutline) {
    // The letter U, three wide and three high, in the plane z = 1.
    ObjectSet set;
    std::vector<Vec3> letter;
    for (const auto& [x, y] :
         {std::pair{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}) {
        letter.emplace_back(x, y, 1.0);
    }
    const uint32_t object = set.add_polygon(letter);
    const auto hit = [&](double x, double y) {
        return intersect(set, object, PreparedRay({Vec3(x, y, 0.0), Vec3(0.0, 0.0, 1.0)}), {}) ==
               1.0;
    };
    for (int i = 0; i < 30; ++i) {
        for (int j = 0; j < 30; ++j) {
            const double x = -0.45 + 0.13 * i;
            const double y = -0.45 + 0.13 * j;
            const bool in = x > 0 && x < 3 && y > 0 && y < 3 && !(x > 1 && x < 2 && y > 1);
            ASSERT_EQ(hit(x, y), in) << x << ' ' << y;
        }
    }
    EXPECT_EQ(normal_at(set, object, Vec3(0.0)), Vec3(0.0, 0.0, 1.0));
}

TEST(IntersectPolygon, AgreesWithItsTrianglesInAnyPlane) {
    RandomStream random(5);
    int hits = 0;
    for (int i = 0; i < 400; ++i) {
        const Vec3 center = test::place(random);
        const std::vector<Vec3> star = test::concave_polygon(random, center, 2.0);
        ObjectSet set;
        const uint32_t polygon = set.add_polygon(star);
        std::vector<uint32_t> fan;  // the star is star-shaped about its centre
        for (size_t k = 0; k < star.size(); ++k) {
            fan.push_back(set.add(Triangle{center, star[k], star[(k + 1) % star.size()]}));
        }
        for (int k = 0; k < 50; ++k) {
            const Vec3 to = center + 2.0 * test::random_direction(random) * random.uniform();
            const PreparedRay ray(ray_to(test::place(random) + Vec3(20.0, 0.0, 0.0), to));
            double nearest = kInfinity;
            for (const uint32_t t : fan) nearest = std::min(nearest, intersect(set, t, ray, kAll));
            const double got = intersect(set, polygon, ray, kAll);
            ASSERT_EQ(got < kInfinity, nearest < kInfinity) << i;
            if (got < kInfinity) {
                ASSERT_NEAR(got, nearest, 1e-9) << i;
                ++hits;
            }
        }
    }
    EXPECT_GT(hits, 1000);
}

TEST(IntersectPolygon, NeighboursLeaveNoGapAndNoOverlap) {
    // A square cut into two concave halves by a zigzag: every ray through it meets one of them,
    // also those at the zigzag's own vertices.
    ObjectSet set;
    const std::vector<Vec3> zigzag = {Vec3(0.0, 1.0, 0.0), Vec3(1.0, 2.0, 0.0), Vec3(2.0, 0.7, 0.0),
                                      Vec3(3.0, 2.3, 0.0), Vec3(4.0, 1.1, 0.0)};
    std::vector<Vec3> below = zigzag;
    below.emplace_back(4.0, 0.0, 0.0);
    below.emplace_back(0.0, 0.0, 0.0);
    std::vector<Vec3> above = zigzag;
    above.emplace_back(4.0, 4.0, 0.0);
    above.emplace_back(0.0, 4.0, 0.0);
    const uint32_t a = set.add_polygon(below);
    const uint32_t b = set.add_polygon(above);
    RandomStream random(6);
    for (int i = 0; i < 20000; ++i) {
        Vec3 at(0.01 + 3.98 * random.uniform(), 0.01 + 3.98 * random.uniform(), 0.0);
        if (i % 3 == 1) at = zigzag[1 + random.below(3)];
        if (i % 3 == 2) {
            const size_t k = random.below(4);
            at = zigzag[k] + (0.01 + 0.98 * random.uniform()) * (zigzag[k + 1] - zigzag[k]);
        }
        const PreparedRay ray({at + Vec3(0.0, 0.0, 3.0), Vec3(0.0, 0.0, -1.0)});
        const int met = (intersect(set, a, ray, {}) < kInfinity ? 1 : 0) +
                        (intersect(set, b, ray, {}) < kInfinity ? 1 : 0);
        ASSERT_EQ(met, 1) << at.x << ' ' << at.y;
    }
}

TEST(IntersectPolygon, WithoutAreaIsNeverHit) {
    ObjectSet set;
    const uint32_t line =
        set.add_polygon(std::vector<Vec3>{Vec3(0.0), Vec3(1.0), Vec3(2.0), Vec3(1.0)});
    EXPECT_EQ(normal_at(set, line, Vec3(0.0)), Vec3(0.0));
    EXPECT_EQ(intersect(set, line, PreparedRay(ray_to(Vec3(5.0, 0.0, 0.0), Vec3(1.0))), kAll),
              kInfinity);
}

}  // namespace
}  // namespace probebake
