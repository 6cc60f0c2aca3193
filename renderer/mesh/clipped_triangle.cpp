#include "mesh/clipped_triangle.h"

#include <algorithm>

namespace probebake {
namespace {

SurfacePoint between(const SurfacePoint& a, const SurfacePoint& b, double t) {
    return {a.position + t * (b.position - a.position),
            a.barycentric + t * (b.barycentric - a.barycentric)};
}

/// The nearest point on edge i, as (distance², how far along).
std::pair<double, double> nearest_on_edge(const Vec3& a, const Vec3& b, const Vec3& to) {
    const Vec3 edge = b - a;
    const double length2 = glm::dot(edge, edge);
    const double t = length2 > 0.0 ? std::clamp(glm::dot(to - a, edge) / length2, 0.0, 1.0) : 0.0;
    const Vec3 gap = a + t * edge - to;
    return {glm::dot(gap, gap), t};
}

}  // namespace

ClippedTriangle::ClippedTriangle(const std::array<Vec3, 3>& triangle, const Box& box) : size_(3) {
    for (size_t i = 0; i < 3; ++i) {
        corners_[i].position = triangle[i];
        corners_[i].barycentric[static_cast<int>(i)] = 1.0;
    }
    for (int plane = 0; plane < 6 && size_ > 0; ++plane) {
        const int axis = plane / 2;
        const auto depth = [&](const SurfacePoint& p) {
            return plane % 2 == 0 ? p.position[axis] - box.low[axis]
                                  : box.high[axis] - p.position[axis];
        };
        std::array<SurfacePoint, kMostCorners> kept;
        size_t count = 0;
        for (size_t i = 0; i < size_; ++i) {
            const SurfacePoint& a = corners_[i];
            const SurfacePoint& b = corners_[i + 1 < size_ ? i + 1 : 0];
            const double da = depth(a);
            const double db = depth(b);
            // Rounding can make a convex polygon cross a plane more than twice.
            if (da >= 0.0 && count < kMostCorners) kept[count++] = a;
            if ((da < 0.0) != (db < 0.0) && da != 0.0 && db != 0.0 && count < kMostCorners) {
                kept[count++] = between(a, b, da / (da - db));
            }
        }
        corners_ = kept;
        size_ = count;
    }
    for (size_t i = 2; i < size_; ++i) {
        area_ += 0.5 * glm::cross(corners_[i - 1].position - corners_[0].position,
                                  corners_[i].position - corners_[0].position);
    }
}

SurfacePoint ClippedTriangle::middle() const {
    SurfacePoint sum;
    double weight = 0.0;
    const double whole = glm::length(area_);
    for (size_t i = 2; whole > 0.0 && i < size_; ++i) {
        const double part = glm::length(glm::cross(corners_[i - 1].position - corners_[0].position,
                                                   corners_[i].position - corners_[0].position));
        for (const size_t k : {size_t{0}, i - 1, i}) {
            sum.position += part / 3.0 * corners_[k].position;
            sum.barycentric += part / 3.0 * corners_[k].barycentric;
        }
        weight += part;
    }
    for (size_t i = 0; !(weight > 0.0) && i < size_; ++i) {
        sum.position += corners_[i].position;
        sum.barycentric += corners_[i].barycentric;
    }
    if (!(weight > 0.0)) weight = static_cast<double>(size_);
    return {sum.position / weight, sum.barycentric / weight};
}

SurfacePoint nearest_point(const std::array<Vec3, 3>& triangle, const Vec3& to) {
    const Vec3 e1 = triangle[1] - triangle[0];
    const Vec3 e2 = triangle[2] - triangle[0];
    const Vec3 normal = glm::cross(e1, e2);
    const double size2 = glm::dot(normal, normal);
    if (size2 > 0.0) {
        const Vec3 d = to - triangle[0];
        const double b1 = glm::dot(glm::cross(d, e2), normal) / size2;
        const double b2 = glm::dot(glm::cross(e1, d), normal) / size2;
        if (b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0) {
            return {triangle[0] + b1 * e1 + b2 * e2, {1.0 - b1 - b2, b1, b2}};
        }
    }
    double least = std::numeric_limits<double>::infinity();
    SurfacePoint nearest;
    for (size_t i = 0; i < 3; ++i) {
        const size_t j = (i + 1) % 3;
        const auto [distance2, t] = nearest_on_edge(triangle[i], triangle[j], to);
        if (!(distance2 < least)) continue;
        least = distance2;
        nearest.position = triangle[i] + t * (triangle[j] - triangle[i]);
        nearest.barycentric = Vec3(0.0);
        nearest.barycentric[static_cast<int>(i)] = 1.0 - t;
        nearest.barycentric[static_cast<int>(j)] = t;
    }
    return nearest;
}

}  // namespace probebake
