// Families of rays that break octree traversals, after the robustness list for Havran 1999's
// octrees: what is generic, and every way to be aligned, grazing, tiny, far or degenerate.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "math/random.h"
#include "math/ray.h"

namespace probebake::test {

struct RayFamily {
    std::string name;
    /// A ray for the cube [0, side]³ whose split planes are the integers.
    std::function<Ray(RandomStream&, double side)> make;
    /// False where a ray has no direction at all: then only an answer is asked for, a miss.
    bool well_defined = true;
};

inline Vec3 random_point(RandomStream& random, double side) {
    return Vec3(random.uniform(), random.uniform(), random.uniform()) * side;
}

inline Vec3 random_corner(RandomStream& random, double side) {
    const auto n = static_cast<uint64_t>(side) + 1;
    return {static_cast<double>(random.below(n)), static_cast<double>(random.below(n)),
            static_cast<double>(random.below(n))};
}

inline Vec3 random_direction(RandomStream& random) {
    for (;;) {
        const Vec3 d = Vec3(random.uniform(), random.uniform(), random.uniform()) * 2.0 - Vec3(1.0);
        const double length = glm::length(d);
        if (length > 0.1 && length <= 1.0) return d / length;
    }
}

inline Vec3 random_axis(RandomStream& random) {
    Vec3 d(0.0);
    d[static_cast<int>(random.below(3))] = random.below(2) == 0 ? 1.0 : -1.0;
    return d;
}

inline Vec3 random_diagonal(RandomStream& random) {
    Vec3 d(0.0);
    do {
        for (int a = 0; a < 3; ++a) d[a] = static_cast<double>(random.below(3)) - 1.0;
    } while (std::abs(d.x) + std::abs(d.y) + std::abs(d.z) < 1.5);
    return glm::normalize(d);
}

/// From a point outside towards `target`.
inline Ray towards(RandomStream& random, const Vec3& target, double distance) {
    const Vec3 d = random_direction(random);
    return {target - d * distance, d};
}

inline std::vector<RayFamily> ray_families() {
    std::vector<RayFamily> families;
    const auto add = [&](const std::string& name, auto make, bool well_defined = true) {
        families.push_back({name, make, well_defined});
    };
    add("generic", [](RandomStream& r, double s) { return towards(r, random_point(r, s), 2 * s); });
    add("axis-parallel", [](RandomStream& r, double s) {
        const Vec3 d = random_axis(r);
        return Ray{random_point(r, s) - d * (1.5 * s), d};
    });
    add("in a split plane", [](RandomStream& r, double s) {
        const int axis = static_cast<int>(r.below(3));
        Vec3 d = random_direction(r);
        d[axis] = r.below(2) == 0 ? 0.0 : -0.0;
        d = glm::normalize(d);
        Vec3 target = random_point(r, s);
        target[axis] = random_corner(r, s)[axis];
        Ray ray{target - d * (2 * s), d};
        ray.origin[axis] = target[axis];
        return ray;
    });
    add("along a split edge", [](RandomStream& r, double s) {
        const int axis = static_cast<int>(r.below(3));
        Vec3 d(r.below(2) == 0 ? 0.0 : -0.0);
        d[axis] = r.below(2) == 0 ? 1.0 : -1.0;
        Vec3 origin = random_corner(r, s);
        origin[axis] = d[axis] > 0 ? -s : 2 * s;
        return Ray{origin, d};
    });
    add("through corners", [](RandomStream& r, double s) {
        const Vec3 from = random_corner(r, s);
        Vec3 to = random_corner(r, s);
        while (to == from) to = random_corner(r, s);
        const Vec3 d = glm::normalize(to - from);
        return Ray{from - (to - from) * 4.0, d};
    });
    add("45 degrees through corners", [](RandomStream& r, double s) {
        const Vec3 d = random_diagonal(r);
        const Vec3 step(d.x == 0 ? 0 : std::copysign(1.0, d.x),
                        d.y == 0 ? 0 : std::copysign(1.0, d.y),
                        d.z == 0 ? 0 : std::copysign(1.0, d.z));
        return Ray{random_corner(r, s) - step * (2 * s), d};
    });
    add("origin on a split corner", [](RandomStream& r, double s) {
        return Ray{random_corner(r, s), r.below(2) == 0 ? random_direction(r) : random_diagonal(r)};
    });
    add("origin on a root face", [](RandomStream& r, double s) {
        Ray ray{random_point(r, s), random_direction(r)};
        ray.origin[static_cast<int>(r.below(3))] = r.below(2) == 0 ? 0.0 : s;
        return ray;
    });
    add("grazing a root face", [](RandomStream& r, double s) {
        const int axis = static_cast<int>(r.below(3));
        Vec3 d = random_direction(r);
        d[axis] = 1e-9 * (r.uniform() - 0.5);
        d = glm::normalize(d);
        Vec3 target = random_point(r, s);
        target[axis] = r.below(2) == 0 ? 0.0 : s;
        return Ray{target - d * (2 * s), d};
    });
    add("origins 1e6 away",
        [](RandomStream& r, double s) { return towards(r, random_point(r, s), 1e6); });
    add("tiny components", [](RandomStream& r, double s) {
        Vec3 d = random_axis(r);
        for (int a = 0; a < 3; ++a) {
            if (d[a] == 0.0)
                d[a] = (r.uniform() - 0.5) * std::pow(10.0, -5.0 - 300.0 * r.uniform());
        }
        return Ray{random_point(r, s) - d * s, d};
    });
    add("long directions", [](RandomStream& r, double s) {
        Ray ray = towards(r, random_point(r, s), 2 * s);
        ray.direction *= 1e6;
        return ray;
    });
    add("short directions", [](RandomStream& r, double s) {
        Ray ray = towards(r, random_point(r, s), 2 * s);
        ray.direction *= 1e-6;
        return ray;
    });
    add("inside starts", [](RandomStream& r, double s) {
        return Ray{random_point(r, s), random_direction(r)};
    });
    add(
        "zero directions",
        [](RandomStream& r, double s) {
            return Ray{random_point(r, s), Vec3(0.0)};
        },
        false);
    add(
        "NaN and Inf",
        [](RandomStream& r, double s) {
            constexpr double kBad[] = {std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::infinity(),
                                       -std::numeric_limits<double>::infinity()};
            Ray ray{random_point(r, s), random_direction(r)};
            Vec3& part = r.below(2) == 0 ? ray.origin : ray.direction;
            part[static_cast<int>(r.below(3))] = kBad[r.below(3)];
            return ray;
        },
        false);
    return families;
}

}  // namespace probebake::test
