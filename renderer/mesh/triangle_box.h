// TriangleBox: whether a triangle and a box share a point, both closed, decided exactly.
//
// Coordinates are integers (grid_mesh.h: 4096 units to a voxel). The test is the one of separating
// axes (Akenine-Möller 2001): the box's three normals, the triangle's normal, and the cross
// products of its edges with the box's. It is complete for triangles that are segments or points,
// too: an axis that vanishes separates nothing.
//
// Exact because nothing is ever rounded: with coordinates in [0, 2^28] an edge has 29 bits and
// twice a vertex's distance from twice the box's middle 30, a normal 59. Projections on cross
// products are two products of 59 bits each, within 64; those on the normal need 91 and are made in
// 128, and only where double precision, off by less than 2^-49 of the terms' sizes, cannot tell.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "math/vec.h"

namespace probebake {

using I64Vec3 = glm::i64vec3;

/// Coordinates of triangles and boxes lie in [0, kMostGridUnits].
inline constexpr int64_t kMostGridUnits = int64_t{1} << 28;

class TriangleBox {
  public:
    explicit TriangleBox(const std::array<IVec3, 3>& vertices)
        : vertices_{I64Vec3(vertices[0]), I64Vec3(vertices[1]), I64Vec3(vertices[2])},
          low_(glm::min(glm::min(vertices[0], vertices[1]), vertices[2])),
          high_(glm::max(glm::max(vertices[0], vertices[1]), vertices[2])) {
        for (size_t i = 0; i < 3; ++i) edges_[i] = vertices_[(i + 1) % 3] - vertices_[i];
        const I64Vec3& e = edges_[0];
        const I64Vec3& f = edges_[1];  // glm::cross is for floating point alone
        normal_ = {e.y * f.z - e.z * f.y, e.z * f.x - e.x * f.z, e.x * f.y - e.y * f.x};
    }

    const IVec3& low() const { return low_; }
    const IVec3& high() const { return high_; }

    /// With the box [low, low + edge]³.
    bool overlaps(const IVec3& low, int edge) const {
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) {
            if (high_[axis] < low[axis] || low_[axis] > low[axis] + edge) return false;
            inside &= low_[axis] >= low[axis] && high_[axis] <= low[axis] + edge;
        }
        if (inside) return true;
        // Everything doubled, and seen from the box's middle.
        std::array<I64Vec3, 3> v;
        for (size_t i = 0; i < 3; ++i) {
            v[i] = int64_t{2} * (vertices_[i] - I64Vec3(low)) - I64Vec3(edge);
        }
        return meets_plane(v[0], edge) && !is_apart_on_a_cross_product(v, edge);
    }

  private:
    bool meets_plane(const I64Vec3& v, int64_t half) const {
        const glm::dvec3 n(normal_);
        const glm::dvec3 p(v);
        const double distance = n.x * p.x + n.y * p.y + n.z * p.z;
        const double reach =
            static_cast<double>(half) * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
        const double doubt =
            0x1p-49 * (std::abs(n.x * p.x) + std::abs(n.y * p.y) + std::abs(n.z * p.z) + reach);
        const double gap = std::abs(distance) - reach;
        if (gap > doubt) return false;
        if (gap < -doubt) return true;
        using Int128 = __int128;
        const auto product = [](int64_t a, int64_t b) { return static_cast<Int128>(a) * b; };
        Int128 exact = product(normal_.x, v.x) + product(normal_.y, v.y) + product(normal_.z, v.z);
        if (exact < 0) exact = -exact;
        const auto size = [](int64_t a) { return a < 0 ? -a : a; };
        return exact <= product(half, size(normal_.x)) + product(half, size(normal_.y)) +
                            product(half, size(normal_.z));
    }

    /// Axis j crossed with an edge: (0, −e.z, e.y) for x, and so on around.
    bool is_apart_on_a_cross_product(const std::array<I64Vec3, 3>& v, int64_t half) const {
        for (size_t i = 0; i < 3; ++i) {
            const I64Vec3& e = edges_[i];
            // Both ends of an edge have the same projection: the third vertex is the other one.
            const I64Vec3& on = v[i];
            const I64Vec3& off = v[(i + 2) % 3];
            for (int j = 0; j < 3; ++j) {
                const int a = (j + 1) % 3;
                const int b = (j + 2) % 3;
                const int64_t p = e[a] * on[b] - e[b] * on[a];
                const int64_t q = e[a] * off[b] - e[b] * off[a];
                const int64_t reach =
                    half * ((e[a] < 0 ? -e[a] : e[a]) + (e[b] < 0 ? -e[b] : e[b]));
                if (std::min(p, q) > reach || std::max(p, q) < -reach) return true;
            }
        }
        return false;
    }

    std::array<I64Vec3, 3> vertices_;
    std::array<I64Vec3, 3> edges_;
    I64Vec3 normal_{0};
    IVec3 low_;
    IVec3 high_;
};

}  // namespace probebake
