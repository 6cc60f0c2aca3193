#include "mesh/grid_mesh.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <tuple>

#include "math/box.h"
#include "voxels/voxel_tree.h"

namespace probebake {
namespace {

constexpr int kMostVoxels = 1 << kMaxDepth;

Box box_of(const TriangleMesh& mesh) {
    Box box = empty_box();
    for (const MeshTriangle& triangle : mesh.triangles) {
        for (const uint32_t vertex : triangle.vertices) {
            const Vec3& p = mesh.positions[vertex];
            if (!is_finite(p)) throw std::invalid_argument("a vertex whose position is not finite");
            box = join(box, p);
        }
    }
    if (mesh.triangles.empty()) return {};
    return box;
}

class Rounding {
  public:
    Rounding(const Vec3& corner_m, double voxel_size_m)
        : corner_m_(corner_m), units_per_m_(kGridUnits / voxel_size_m) {}

    IVec3 operator()(const Vec3& position_m) const {
        return IVec3(glm::floor((position_m - corner_m_) * units_per_m_ + 0.5));
    }

  private:
    Vec3 corner_m_;
    double units_per_m_;
};

/// All that tells one corner of a triangle from another.
class Order {
  public:
    explicit Order(const TriangleMesh& mesh) : mesh_(mesh) {}

    bool operator()(const GridTriangle& a, const GridTriangle& b) const {
        for (size_t i = 0; i < 3; ++i) {
            const int order = compare(a.vertices[i], b.vertices[i]);
            if (order != 0) return order < 0;
        }
        if (a.material != b.material) return a.material < b.material;
        for (size_t i = 0; i < 3; ++i) {
            const int order = compare_looks(a.corners[i], b.corners[i]);
            if (order != 0) return order < 0;
        }
        return false;
    }

    /// Turns the triangle so that its lowest corner comes first.
    void turn(GridTriangle& triangle) const {
        size_t lowest = 0;
        for (size_t i = 1; i < 3; ++i) {
            if (compare_corners(triangle, i, lowest) < 0) lowest = i;
        }
        const auto by = static_cast<std::ptrdiff_t>(lowest);
        std::rotate(triangle.vertices.begin(), triangle.vertices.begin() + by,
                    triangle.vertices.end());
        std::rotate(triangle.corners.begin(), triangle.corners.begin() + by,
                    triangle.corners.end());
    }

  private:
    template <class T>
    static int sign(const T& a, const T& b) {
        return a < b ? -1 : (b < a ? 1 : 0);
    }
    static int compare(const IVec3& a, const IVec3& b) {
        return sign(std::tie(a.x, a.y, a.z), std::tie(b.x, b.y, b.z));
    }
    int compare_looks(uint32_t a, uint32_t b) const {
        if (!mesh_.texture_coordinates.empty()) {
            const Vec2& p = mesh_.texture_coordinates[a];
            const Vec2& q = mesh_.texture_coordinates[b];
            const int order = sign(std::tie(p.x, p.y), std::tie(q.x, q.y));
            if (order != 0) return order;
        }
        return mesh_.colors.empty() ? 0 : sign(mesh_.colors[a], mesh_.colors[b]);
    }
    /// A triangle with two equal corners is turned by the third, which the next one tells.
    int compare_corners(const GridTriangle& t, size_t a, size_t b) const {
        for (size_t i = 0; i < 3; ++i) {
            const size_t p = (a + i) % 3;
            const size_t q = (b + i) % 3;
            int order = compare(t.vertices[p], t.vertices[q]);
            if (order == 0) order = compare_looks(t.corners[p], t.corners[q]);
            if (order != 0) return order;
        }
        return 0;
    }

    const TriangleMesh& mesh_;
};

Vec3 default_corner_m(const Box& box, double voxel_size_m) {
    return (glm::floor(box.low / voxel_size_m) - 0.5) * voxel_size_m;
}

}  // namespace

GridMesh make_grid_mesh(const TriangleMesh& mesh, double voxel_size_m,
                        const std::optional<Vec3>& corner_m) {
    if (!(voxel_size_m > 0.0) || !std::isfinite(voxel_size_m)) {
        throw std::invalid_argument("a voxel size of " + std::to_string(voxel_size_m) +
                                    " m; expected more than 0");
    }
    const Box box = box_of(mesh);
    GridMesh grid{.triangles = {},
                  .corner_m = corner_m.value_or(default_corner_m(box, voxel_size_m)),
                  .voxel_size_m = voxel_size_m};
    const Vec3 low = (box.low - grid.corner_m) / voxel_size_m;
    const Vec3 high = (box.high - grid.corner_m) / voxel_size_m;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(low[axis] >= 0.0)) {
            throw std::invalid_argument("the mesh begins " + std::to_string(-low[axis]) +
                                        " voxels before the corner of its world");
        }
        // Half a unit below the end, so that rounding cannot pass it.
        if (!(high[axis] < kMostVoxels - 0.001)) {
            throw std::invalid_argument(
                "a world has at most 65536 voxels per axis; at this voxel size the mesh needs " +
                std::to_string(high[axis]));
        }
    }
    const Rounding rounded(grid.corner_m, voxel_size_m);
    const Order order(mesh);
    grid.triangles.reserve(mesh.triangles.size());
    IVec3 most(0);
    for (const MeshTriangle& triangle : mesh.triangles) {
        GridTriangle placed{.vertices = {}, .corners = triangle.vertices};
        placed.material = triangle.material;
        for (size_t i = 0; i < 3; ++i) {
            placed.vertices[i] = rounded(mesh.positions[triangle.vertices[i]]);
            most = glm::max(most, placed.vertices[i]);
        }
        order.turn(placed);
        grid.triangles.push_back(placed);
    }
    tbb::parallel_sort(grid.triangles.begin(), grid.triangles.end(), order);
    // What lies on a plane touches the voxel behind it, which the world may be too small for.
    grid.extent = glm::min(most / kGridUnits + 1, IVec3(kMostVoxels));
    return grid;
}

}  // namespace probebake
