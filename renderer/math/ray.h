// A ray and the reciprocal of its direction, safe for every direction.
#pragma once

#include <cmath>

#include "math/vec.h"

namespace probebake {

/// Origin and unit direction; units are those of the space that the ray lives in.
struct Ray {
    Vec3 origin{0.0};
    Vec3 direction{0.0, 0.0, 1.0};
};

/// What a zero component of a direction is replaced by. With it, a plane parameter
/// (plane − origin) / direction stays finite, and a ray inside a plane belongs to the side that
/// its signed zero heads for; no traversal has a special case (Havran 1999; docs/decisions.md).
inline constexpr double kTinyDirection = 1e-200;

inline Vec3 safe_direction(const Vec3& d) {
    const auto fix = [](double x) {
        return std::abs(x) < kTinyDirection ? std::copysign(kTinyDirection, x) : x;
    };
    return {fix(d.x), fix(d.y), fix(d.z)};
}

}  // namespace probebake
