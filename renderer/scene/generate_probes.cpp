// suggested_probes(): one position in each cell of a grid over the world, above what a ray from
// above meets first.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "math/random.h"
#include "scene/generate_cornell.h"
#include "scene/generate_scene.h"
#include "voxels/trace.h"

namespace probebake {
namespace {

constexpr int kTries = 64;  // positions tried in each cell
constexpr double kLowest_m = 2.0;
constexpr double kHighest_m = 10.0;
constexpr double kClearance_m = 1.0;

/// The floor plan that probes are spread over, in voxels.
struct Plan {
    Vec2 lo;
    Vec2 hi;
};

Plan plan_of(const GeneratorParams& params) {
    if (params.name == "cornell") {
        return {{cornell::kFloorRegionMin.x, cornell::kFloorRegionMin.z},
                {cornell::kFloorRegionMax.x, cornell::kFloorRegionMax.z}};
    }
    const double margin = 0.06 * params.size;
    return {Vec2(margin), Vec2(params.size - margin)};
}

/// Top of the highest voxel of a column; none where it is empty.
std::optional<double> surface_y(const VoxelTree& tree, const Vec2& at, int size) {
    const Hit hit = trace(tree, {Vec3(at.x, size + 1.0, at.y), Vec3(0.0, -1.0, 0.0)});
    if (!hit) return std::nullopt;
    return hit.corner.y + 1.0;
}

bool is_clear(const VoxelTree& tree, const Vec3& at, double clearance) {
    const IVec3 lo = IVec3(glm::floor(at - clearance));
    const IVec3 hi = IVec3(glm::floor(at + clearance));
    for (int z = lo.z; z <= hi.z; ++z) {
        for (int y = lo.y; y <= hi.y; ++y) {
            for (int x = lo.x; x <= hi.x; ++x) {
                if (tree.occupied({x, y, z})) return false;
            }
        }
    }
    return true;
}

/// Whether the surface stands out by more than `step` over what lies around: a crown or a roof.
bool stands_out(const VoxelTree& tree, const Vec2& at, double y, double step, int size) {
    for (const Vec2 away : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)}) {
        const std::optional<double> beside = surface_y(tree, at + away * step, size);
        if (beside && y - *beside > step) return true;
    }
    return false;
}

}  // namespace

std::vector<Vec3> suggested_probes(const VoxelTree& tree, const GeneratorParams& params,
                                   int count) {
    if (count < 0) throw std::invalid_argument("the number of probes is at least 0");
    const double voxel_m = voxel_size_m(params);
    // At least a voxel, and less where the world itself is some metres across.
    const double clearance = std::clamp(kClearance_m / voxel_m, 1.0, params.size / 16.0);
    const Plan plan = plan_of(params);
    const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
    const int rows = columns == 0 ? 0 : (count + columns - 1) / columns;
    std::vector<Vec3> probes;
    for (int i = 0; i < count; ++i) {
        const int row = i / columns;
        const int in_row = std::min(columns, count - row * columns);  // the last may hold fewer
        RandomStream random(random_key({params.seed, 81, static_cast<uint64_t>(i)}));
        for (int attempt = 0; attempt < kTries; ++attempt) {
            const Vec2 inside{random.uniform(), random.uniform()};
            const double height_m = kLowest_m + (kHighest_m - kLowest_m) * random.uniform();
            const Vec2 share = (Vec2(i % columns, row) + inside) / Vec2(in_row, rows);
            const Vec2 at = plan.lo + (plan.hi - plan.lo) * share;
            const std::optional<double> surface = surface_y(tree, at, params.size);
            // Under a low sky, half of the air; beside a lone object, half of the way up.
            const double air = surface ? params.size - *surface : 0.0;
            const double y = surface
                                 ? *surface + std::min(0.5 * air, std::max(1.5, height_m / voxel_m))
                                 : 0.5 * params.size;
            const Vec3 position(at.x, y, at.y);
            if (!is_clear(tree, position, clearance)) continue;
            const bool last_resort = attempt >= kTries / 2;
            const double step = std::max(2.0, 3.0 / voxel_m);
            if (surface && !last_resort && stands_out(tree, at, *surface, step, params.size))
                continue;
            probes.push_back(position);
            break;
        }
    }
    return probes;
}

}  // namespace probebake
