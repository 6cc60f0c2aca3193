#include "scene/probe_validity.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

#include "voxels/trace.h"

namespace probebake {
namespace {

constexpr int kDirections = 64;
constexpr int kSteps = 8;  // to either side, per axis

/// Spread evenly over the sphere (a spiral of golden angles).
std::array<Vec3, kDirections> make_directions() {
    std::array<Vec3, kDirections> directions;
    const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
    for (size_t i = 0; i < directions.size(); ++i) {
        const double y = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / kDirections;
        const double r = std::sqrt(1.0 - y * y);
        const double angle = turn * static_cast<double>(i);
        directions[i] = {r * std::cos(angle), y, r * std::sin(angle)};
    }
    return directions;
}

/// The nearest voxel's distance, best children first.
class NearestVoxel {
  public:
    NearestVoxel(const VoxelTree& tree, const Vec3& point) : tree_(tree), point_(point) {}

    double distance() {
        if (!tree_.empty()) visit(tree_.node_levels() - 1, 0, IVec3(0));
        return std::sqrt(least2_);
    }

  private:
    double distance2(const IVec3& low, int edge) const {
        const Vec3 nearest = glm::clamp(point_, Vec3(low), Vec3(low) + Vec3(edge));
        const Vec3 gap = point_ - nearest;
        return glm::dot(gap, gap);
    }

    void visit(int k, uint32_t index, const IVec3& corner) {
        const VoxelNode& node = tree_.nodes()[index];
        const int edge = 1 << (2 * k);
        std::array<std::pair<double, uint32_t>, 64> cells;
        size_t count = 0;
        for (uint64_t rest = node.mask; rest != 0; rest &= rest - 1) {
            const auto bit = static_cast<uint32_t>(std::countr_zero(rest));
            const double d2 = distance2(corner + morton_decode(bit) * edge, edge);
            if (d2 < least2_) cells[count++] = {d2, bit};
        }
        std::sort(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(count));
        for (size_t i = 0; i < count && cells[i].first < least2_; ++i) {
            const auto [d2, bit] = cells[i];
            if (k == 0) {
                least2_ = d2;
            } else {
                visit(k - 1, node.first_child + rank_below(node.mask, bit),
                      corner + morton_decode(bit) * edge);
            }
        }
    }

    const VoxelTree& tree_;
    Vec3 point_;
    double least2_ = std::numeric_limits<double>::infinity();
};

double backface_at(const Scene& scene, const Vec3& position_m) {
    static const std::array<Vec3, kDirections> kAll = make_directions();
    const Vec3 origin = scene.to_voxels(position_m);
    int near = 0;
    for (const Vec3& direction : kAll) {
        if (trace(scene.tree, {origin, direction}, {}, {.t_max = 1.0})) ++near;
    }
    return static_cast<double>(near) / kDirections;
}

}  // namespace

ProbePlace look_at_place(const Scene& scene, const Vec3& position_m) {
    ProbePlace place{.inside_geometry = scene.inside_voxel(position_m)};
    place.backface = place.inside_geometry ? 1.0 : backface_at(scene, position_m);
    place.nearest_surface_m =
        NearestVoxel(scene.tree, scene.to_voxels(position_m)).distance() * scene.voxel_size_m;
    return place;
}

Vec3 relocated(const Scene& scene, const Vec3& position_m, const Vec3& most_offset_m,
               double max_backface) {
    const auto is_valid = [&](const Vec3& at) {
        return !scene.inside_voxel(at) && backface_at(scene, at) <= max_backface;
    };
    if (is_valid(position_m)) return position_m;
    struct Candidate {
        double distance2;
        IVec3 step;  // −kSteps to kSteps
    };
    std::vector<Candidate> candidates;
    for (int z = -kSteps; z <= kSteps; ++z) {
        for (int y = -kSteps; y <= kSteps; ++y) {
            for (int x = -kSteps; x <= kSteps; ++x) {
                const Vec3 offset = Vec3(x, y, z) / double(kSteps) * most_offset_m;
                candidates.push_back({glm::dot(offset, offset), {x, y, z}});
            }
        }
    }
    // In rising z, y, x already.
    std::stable_sort(
        candidates.begin(), candidates.end(),
        [](const Candidate& a, const Candidate& b) { return a.distance2 < b.distance2; });
    for (const Candidate& candidate : candidates) {
        const Vec3 at = position_m + Vec3(candidate.step) / double(kSteps) * most_offset_m;
        if (is_valid(at)) return at;
    }
    return position_m;
}

}  // namespace probebake
