// Affine maps and axis-aligned boxes of world and index spaces.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "math/ray.h"

namespace probebake {

struct Affine {
    glm::dmat3 linear{1.0};
    Vec3 offset{0.0};

    Vec3 point(const Vec3& p) const { return linear * p + offset; }
    Vec3 vector(const Vec3& v) const { return linear * v; }
    /// Requires a regular linear part.
    Affine inverse() const {
        const glm::dmat3 back = glm::inverse(linear);
        return {back, -(back * offset)};
    }
    /// First `before`, then this.
    Affine after(const Affine& before) const {
        return {linear * before.linear, linear * before.offset + offset};
    }
};

struct Box {
    Vec3 low{0.0};
    Vec3 high{0.0};

    bool contains(const Vec3& p) const {
        return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x < high.x && p.y < high.y &&
               p.z < high.z;
    }
};

struct TRange {
    double begin = 0.0;
    double end = std::numeric_limits<double>::infinity();
};

/// The part of `range` that a ray spends in the box; none where it has no length. Directions of
/// any length, as safe_direction makes them.
inline std::optional<TRange> clip(const Box& box, const Ray& ray, TRange range) {
    for (int axis = 0; axis < 3; ++axis) {
        const double inverse = 1.0 / ray.direction[axis];
        const double a = (box.low[axis] - ray.origin[axis]) * inverse;
        const double b = (box.high[axis] - ray.origin[axis]) * inverse;
        range.begin = std::max(range.begin, std::min(a, b));
        range.end = std::min(range.end, std::max(a, b));
    }
    if (!(range.begin < range.end)) return std::nullopt;
    return range;
}

}  // namespace probebake
