#include "scene/suggest_probes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "math/random.h"
#include "voxels/filled_box.h"
#include "voxels/trace.h"

namespace probebake {
namespace {

constexpr int kTries = 64;         // positions tried in each cell
constexpr double kMargin = 0.06;   // of the plan, left free at its border
constexpr double kLowest_m = 2.0;  // above the ground
constexpr double kHighest_m = 10.0;
constexpr double kClearance_m = 1.0;

/// What the voxels fill, in voxels.
class Search {
  public:
    Search(const Scene& scene, const Box& box)
        : tree_(scene.tree),
          middle_y_(0.5 * (box.low.y + box.high.y)),
          voxel_m_(scene.voxel_size_m),
          side_(std::ldexp(1.0, scene.tree.depth())),
          // At least a voxel, and less where the world itself is some metres across.
          clearance_(std::clamp(kClearance_m / voxel_m_, 1.0, std::max(1.0, side_ / 16.0))) {}

    /// A position above a point of the plan, or none where it is not clear. A crown, a roof or a
    /// column without voxels will do as a last resort only.
    std::optional<Vec3> above(const Vec2& at, double height_m, bool last_resort) const {
        const std::optional<double> surface = surface_y(at);
        if (!last_resort && (!surface || stands_out(at, *surface))) return std::nullopt;
        double y = middle_y_;
        if (surface) {  // under a low sky, half of the air
            y = *surface + std::min(0.5 * (side_ - *surface), std::max(1.5, height_m / voxel_m_));
        }
        const Vec3 position(at.x, y, at.y);
        if (!is_clear(position)) return std::nullopt;
        return position;
    }

  private:
    /// Top of the highest voxel of a column; none where it is empty.
    std::optional<double> surface_y(const Vec2& at) const {
        const Hit hit = trace(tree_, {Vec3(at.x, side_ + 1.0, at.y), Vec3(0.0, -1.0, 0.0)});
        if (!hit) return std::nullopt;
        return hit.corner.y + 1.0;
    }

    bool is_clear(const Vec3& at) const {
        const IVec3 lo = IVec3(glm::floor(at - clearance_));
        const IVec3 hi = IVec3(glm::floor(at + clearance_));
        for (int z = lo.z; z <= hi.z; ++z) {
            for (int y = lo.y; y <= hi.y; ++y) {
                for (int x = lo.x; x <= hi.x; ++x) {
                    if (tree_.occupied({x, y, z})) return false;
                }
            }
        }
        return true;
    }

    /// Whether the surface is much higher than what lies around: a crown or a roof.
    bool stands_out(const Vec2& at, double y) const {
        const double step = std::max(2.0, 3.0 / voxel_m_);
        constexpr std::array<std::array<int, 2>, 4> kAround = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
        return std::any_of(kAround.begin(), kAround.end(), [&](const auto& away) {
            const auto beside = surface_y(at + Vec2(away[0], away[1]) * step);
            return beside && y - *beside > step;
        });
    }

    const VoxelTree& tree_;
    double middle_y_;
    double voxel_m_;
    double side_;
    double clearance_;
};

}  // namespace

std::vector<Vec3> suggest_probes(const Scene& scene, int count, uint64_t seed) {
    if (count < 0) throw std::invalid_argument("the number of probes is at least 0");
    std::vector<Vec3> probes;
    if (count == 0 || scene.tree.empty()) return probes;
    const Box box = filled_box(scene.tree);
    const Search search(scene, box);
    const Vec2 side(box.high.x - box.low.x, box.high.z - box.low.z);
    const Vec2 corner = Vec2(box.low.x, box.low.z) + kMargin * side;
    const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
    const int rows = (count + columns - 1) / columns;
    for (int i = 0; i < count; ++i) {
        const int row = i / columns;
        const int in_row = std::min(columns, count - row * columns);  // the last may hold fewer
        RandomStream random(random_key({seed, 81, static_cast<uint64_t>(i)}));
        for (int attempt = 0; attempt < kTries; ++attempt) {
            const double x = random.uniform();
            const double z = random.uniform();
            const double height_m = kLowest_m + (kHighest_m - kLowest_m) * random.uniform();
            const Vec2 share = (Vec2(i % columns, row) + Vec2(x, z)) / Vec2(in_row, rows);
            const Vec2 at = corner + (1.0 - 2.0 * kMargin) * side * share;
            const bool last_resort = attempt >= kTries / 2;
            if (const auto position = search.above(at, height_m, last_resort)) {
                probes.push_back(scene.to_metres(*position));
                break;
            }
        }
    }
    return probes;
}

}  // namespace probebake
