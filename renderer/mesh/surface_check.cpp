#include "mesh/surface_check.h"

#include <algorithm>
#include <cmath>

#include "math/random.h"

namespace probebake {

bool is_covered(const VoxelTree& tree, const Vec3& point) {
    constexpr double kNear = 1e-6;
    const IVec3 low(glm::floor(point - kNear));
    const IVec3 high(glm::floor(point + kNear));
    for (int z = low.z; z <= high.z; ++z) {
        for (int y = low.y; y <= high.y; ++y) {
            for (int x = low.x; x <= high.x; ++x) {
                if (tree.occupied({x, y, z})) return true;
            }
        }
    }
    return false;
}

PointCheck check_points(const GridMesh& grid, const MeshSurface& surface, const VoxelTree& tree,
                        uint64_t points) {
    PointCheck check;
    std::vector<double> areas;
    areas.reserve(grid.triangles.size());
    double sum = 0.0;
    for (const GridTriangle& triangle : grid.triangles) {
        const std::array<Vec3, 3> p = corners_of(triangle);
        sum += 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
        areas.push_back(sum);
    }
    for (uint64_t i = 0; i < points && !areas.empty(); ++i) {
        RandomStream random(random_key({0x706F696E7473, i}));
        const double at = random.uniform() * sum;
        size_t index = random.below(areas.size());
        if (sum > 0.0) {
            const auto found = std::upper_bound(areas.begin(), areas.end(), at);
            index = std::min(static_cast<size_t>(found - areas.begin()), areas.size() - 1);
        }
        const GridTriangle& triangle = grid.triangles[index];
        const double root = std::sqrt(random.uniform());
        const double share = random.uniform();
        const Vec3 barycentric(1.0 - root, root * (1.0 - share), root * share);
        if (!surface.is_there(triangle, barycentric)) continue;
        const std::array<Vec3, 3> p = corners_of(triangle);
        const Vec3 point = barycentric.x * p[0] + barycentric.y * p[1] + barycentric.z * p[2];
        ++check.points;
        if (!is_covered(tree, point)) ++check.uncovered;
    }
    return check;
}

}  // namespace probebake
