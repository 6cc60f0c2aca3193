#include "error/projected_area_error.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "math/ray.h"

namespace probebake {
namespace {

constexpr double kChildHalfSide = 0.25;

Vec3 child_center(size_t octant) {
    return {(octant & 1) != 0 ? 0.25 : -0.25, (octant & 2) != 0 ? 0.25 : -0.25,
            (octant & 4) != 0 ? 0.25 : -0.25};
}

/// A convex polygon. Clipping a rectangle twice leaves six corners, nine if every sign is noise.
struct Polygon {
    std::array<Vec2, 12> corners{};
    size_t count = 0;

    void add(const Vec2& p) { corners[count++] = p; }
};

/// The part of the polygon where side(corner), a linear function, is not negative.
template <class Side>
Polygon clip(const Polygon& polygon, Side side) {
    Polygon kept;
    for (size_t i = 0; i < polygon.count; ++i) {
        const Vec2& p = polygon.corners[i];
        const Vec2& q = polygon.corners[(i + 1) % polygon.count];
        const double at_p = side(p);
        const double at_q = side(q);
        if (at_p >= 0.0) kept.add(p);
        if ((at_p >= 0.0) != (at_q >= 0.0)) kept.add(p + (at_p / (at_p - at_q)) * (q - p));
    }
    return kept;
}

double area(const Polygon& polygon) {
    double twice = 0.0;
    for (size_t i = 1; i + 1 < polygon.count; ++i) {
        const Vec2 p = polygon.corners[i] - polygon.corners[0];
        const Vec2 q = polygon.corners[i + 1] - polygon.corners[0];
        twice += p.x * q.y - p.y * q.x;
    }
    return 0.5 * twice;
}

/// Area across d of the lines whose moment lies within [low, high] in all three components. The
/// component along the largest |d_c| follows from the others: m_c = −(d_a m_a + d_b m_b) / d_c, and
/// an area in the plane of (m_a, m_b) is |d_c| times that across d.
double area_of_moments(const Vec3& d, const Vec3& low, const Vec3& high) {
    const Vec3 size = glm::abs(d);
    const int c = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int a = (c + 1) % 3;
    const int b = (c + 2) % 3;
    if (!(low[a] < high[a] && low[b] < high[b] && low[c] <= high[c])) return 0.0;
    const Polygon rectangle{
        {Vec2(low[a], low[b]), {high[a], low[b]}, {high[a], high[b]}, {low[a], high[b]}}, 4};
    const auto third = [&](const Vec2& m) { return -(d[a] * m.x + d[b] * m.y) / d[c]; };
    const Polygon above = clip(rectangle, [&](const Vec2& m) { return third(m) - low[c]; });
    return area(clip(above, [&](const Vec2& m) { return high[c] - third(m); })) / size[c];
}

}  // namespace

MaskErrors projected_areas(const Vec3& direction) {
    // A component too small to keep its digits in a product moves no area: it is 0.
    Vec3 d = direction;
    for (int a = 0; a < 3; ++a) {
        if (std::abs(d[a]) < kTinyDirection) d[a] = 0.0;
    }
    const Vec3 size = glm::abs(d);
    const Vec3 half_width =
        kChildHalfSide * Vec3(size.y + size.z, size.z + size.x, size.x + size.y);

    // Slabs that the children of each set have in common, from the set without its lowest child.
    std::array<Vec3, kMaskCount> low{};
    std::array<Vec3, kMaskCount> high{};
    MaskErrors areas{};
    for (size_t set = 1; set < kMaskCount; ++set) {
        const Vec3 moment = glm::cross(child_center(static_cast<size_t>(std::countr_zero(set))), d);
        const size_t others = set & (set - 1);
        low[set] = moment - half_width;
        high[set] = moment + half_width;
        if (others != 0) {
            low[set] = glm::max(low[set], low[others]);
            high[set] = glm::min(high[set], high[others]);
        }
        const double common = area_of_moments(d, low[set], high[set]);
        areas[set] = std::popcount(set) % 2 == 1 ? common : -common;
    }
    sum_over_subsets(areas);
    return areas;
}

MaskErrors projected_area_errors(const Vec3& direction) {
    require_unit({&direction, 1});
    const MaskErrors areas = projected_areas(direction);
    MaskErrors errors{};
    for (size_t mask = 0; mask < kMaskCount; ++mask) {
        errors[mask] = 1.0 - areas[mask] / areas[kMaskCount - 1];
    }
    return errors;
}

ErrorTable projected_area_errors(std::vector<Vec3> directions) {
    require_unit(directions);
    ErrorTable table{std::move(directions), {}};
    table.errors.resize(table.directions.size());
    tbb::parallel_for(size_t{0}, table.directions.size(), [&](size_t i) {
        table.errors[i] = projected_area_errors(table.directions[i]);
    });
    return table;
}

}  // namespace probebake
