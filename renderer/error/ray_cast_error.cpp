#include "error/ray_cast_error.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "math/ray.h"
#include "math/sampling.h"

namespace probebake {
namespace {

/// Sample positions of the frame in [−1, 1]², quarter by quarter.
std::vector<Vec2> frame_samples(int frame_px) {
    const auto side = static_cast<uint32_t>(frame_px / 2);
    std::vector<Vec2> samples;
    samples.reserve(size_t{4} * side * side);
    for (uint32_t quarter = 0; quarter < 4; ++quarter) {
        const Vec2 corner(quarter % 2 == 0 ? -1.0 : 0.0, quarter < 2 ? -1.0 : 0.0);
        for (uint32_t i = 0; i < side * side; ++i) {
            samples.push_back(corner + correlated_multi_jitter(i, side, side, quarter + 1));
        }
    }
    return samples;
}

/// Two unit vectors that span the plane across d; which ones is of no consequence.
std::pair<Vec3, Vec3> image_axes(const Vec3& d) {
    const Vec3 a = glm::abs(d);
    const Vec3 across = a.x <= a.y && a.x <= a.z ? Vec3(1, 0, 0)
                        : a.y <= a.z             ? Vec3(0, 1, 0)
                                                 : Vec3(0, 0, 1);
    const Vec3 right = glm::normalize(glm::cross(across, d));
    return {right, glm::cross(d, right)};
}

MaskErrors cast_frame(const Vec3& direction, std::span<const Vec2> samples) {
    const auto [right, up] = image_axes(direction);
    const Vec3 d = safe_direction(direction);
    // A ray crosses the cube's three middle planes at t = x·mid_x + y·mid_y, the faces half a
    // side before and after.
    const Vec3 mid_x = -right / d;
    const Vec3 mid_y = -up / d;
    const Vec3 half_side = 0.5 / glm::abs(d);

    // Counted as if d pointed into the +++ octant: bit a of an octant is set behind plane a.
    std::array<uint32_t, kMaskCount> rays_by_set{};
    for (const Vec2& sample : samples) {
        const Vec3 mid = sample.x * mid_x + sample.y * mid_y;
        const Vec3 near = mid - half_side;
        const Vec3 far = mid + half_side;
        const double enter = std::max({near.x, near.y, near.z});
        const double leave = std::min({far.x, far.y, far.z});
        if (!(enter < leave)) continue;
        const auto octant_after = [&mid](double t) {
            return (mid.x <= t ? 1u : 0u) | (mid.y <= t ? 2u : 0u) | (mid.z <= t ? 4u : 0u);
        };
        // The ray changes octant only at the middle planes that it crosses inside the cube.
        unsigned passed = 1u << octant_after(enter);
        for (int a = 0; a < 3; ++a) {
            if (enter < mid[a] && mid[a] < leave) passed |= 1u << octant_after(mid[a]);
        }
        ++rays_by_set[passed];
    }

    std::array<uint32_t, kMaskCount> rays_within{};
    for (size_t set = 0; set < kMaskCount; ++set) {
        rays_within[mirror_mask(static_cast<uint8_t>(set), negative_axes(d))] = rays_by_set[set];
    }
    sum_over_subsets(rays_within);
    MaskErrors errors{};
    for (size_t mask = 0; mask < kMaskCount; ++mask) {
        const double misses = rays_within[kMaskCount - 1 - mask];  // sets within the complement
        errors[mask] = misses / rays_within[kMaskCount - 1];
    }
    return errors;
}

}  // namespace

ErrorTable ray_cast_errors(std::vector<Vec3> directions, int frame_px) {
    if (frame_px < 8 || frame_px > 4096 || frame_px % 2 != 0) {
        throw std::invalid_argument("ray_cast_errors: expected an even frame_px from 8 to 4096");
    }
    require_unit(directions);
    const std::vector<Vec2> samples = frame_samples(frame_px);
    ErrorTable table{std::move(directions), {}};
    table.errors.resize(table.directions.size());
    tbb::parallel_for(size_t{0}, table.directions.size(), [&](size_t i) {
        table.errors[i] = cast_frame(table.directions[i], samples);
    });
    return table;
}

}  // namespace probebake
