#include "scene/triangulate_polygon.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace probebake {
namespace {

using Triangles = std::vector<std::array<uint32_t, 3>>;

/// Twice the signed area of a triangle.
double cross(const Vec2& a, const Vec2& b, const Vec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The corners in a plane in which they turn counter-clockwise.
std::vector<Vec2> flatten(std::span<const Vec3> corners) {
    Vec3 normal(0.0);
    for (size_t i = 0; i < corners.size(); ++i) {
        // From the first corner, so that far-away polygons lose no digits.
        const Vec3 a = corners[i] - corners[0];
        const Vec3 b = corners[(i + 1) % corners.size()] - corners[0];
        normal += glm::cross(a, b);
    }
    const Vec3 size = glm::abs(normal);
    int drop = size.x > size.y ? 0 : 1;
    if (size.z > size[drop]) drop = 2;
    int u = (drop + 1) % 3;
    int v = (drop + 2) % 3;
    if (normal[drop] < 0.0) std::swap(u, v);
    std::vector<Vec2> flat;
    flat.reserve(corners.size());
    for (const Vec3& corner : corners) {
        const Vec3 p = corner - corners[0];
        flat.emplace_back(p[u], p[v]);
    }
    return flat;
}

/// Whether every corner turns the same way, and the ring goes round once.
bool is_convex(const std::vector<Vec2>& ring) {
    const size_t n = ring.size();
    int turns_in_x = 0;
    double last = 0.0;
    for (size_t i = 0; i < n; ++i) {
        if (!(cross(ring[i], ring[(i + 1) % n], ring[(i + 2) % n]) >= 0.0)) return false;
    }
    for (size_t i = 0; i < 2 * n; ++i) {
        const double step = ring[(i + 1) % n].x - ring[i % n].x;
        if (step == 0.0) continue;
        if (i >= n && step * last < 0.0) ++turns_in_x;
        last = step;
    }
    return turns_in_x <= 2;
}

bool is_ear(const std::vector<Vec2>& flat, const std::vector<uint32_t>& ring, size_t at) {
    const size_t n = ring.size();
    const Vec2& a = flat[ring[(at + n - 1) % n]];
    const Vec2& b = flat[ring[at]];
    const Vec2& c = flat[ring[(at + 1) % n]];
    if (!(cross(a, b, c) > 0.0)) return false;
    return std::none_of(ring.begin(), ring.end(), [&](uint32_t i) {
        const Vec2& p = flat[i];
        // The ring may come by the same point twice: along a bridge to a hole.
        if (p == a || p == b || p == c) return false;
        return cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0;
    });
}

}  // namespace

std::optional<Triangles> triangulate_polygon(std::span<const Vec3> corners) {
    Triangles triangles;
    if (corners.size() < 3) return triangles;
    const std::vector<Vec2> flat = flatten(corners);
    std::vector<uint32_t> ring(corners.size());
    std::iota(ring.begin(), ring.end(), 0u);
    if (is_convex(flat)) {
        for (uint32_t i = 2; i < ring.size(); ++i) triangles.push_back({0, i - 1, i});
        return triangles;
    }
    if (ring.size() > kMaxConcaveCorners) return std::nullopt;
    size_t at = 0;
    size_t failures = 0;
    while (ring.size() > 3) {
        at %= ring.size();
        // Rings that cross themselves run out of ears: any corner will do then.
        if (failures < ring.size() && !is_ear(flat, ring, at)) {
            ++at;
            ++failures;
            continue;
        }
        const size_t n = ring.size();
        triangles.push_back({ring[(at + n - 1) % n], ring[at], ring[(at + 1) % n]});
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(at));
        failures = 0;
        if (at > 0) --at;
    }
    triangles.push_back({ring[0], ring[1], ring[2]});
    return triangles;
}

}  // namespace probebake
