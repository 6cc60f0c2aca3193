#include "mesh/voxel_look.h"

#include <algorithm>
#include <cmath>

namespace probebake {
namespace {

/// The least share of a box's side that a plane through its middle covers, along the axis from
/// which it covers most: that of the planes across a diagonal.
constexpr double kLeastCover = 0.75;

Box voxel_box(const Vec3& middle) { return {middle - Vec3(0.5), middle + Vec3(0.5)}; }

/// What emitters do in a voxel's box around a point.
struct Glow {
    double cover = 0.0;  // of the box's side, 0 to 1
    double area = 0.0;   // of their surface in it
};

Glow glow_around(const GridMesh& grid, const MeshSurface& surface, const Vec3& middle,
                 std::span<const uint32_t> glowing) {
    Vec3 up(0.0);
    Vec3 down(0.0);
    Glow glow;
    for (const uint32_t index : glowing) {
        const GridTriangle& triangle = grid.triangles[index];
        const ClippedTriangle part(corners_of(triangle), voxel_box(middle));
        glow.area += glm::length(part.area());
        up += glm::max(part.area(), Vec3(0.0));
        down += glm::max(-part.area(), Vec3(0.0));
        if (surface.shines_on_both_sides(triangle)) {
            up += glm::max(-part.area(), Vec3(0.0));
            down += glm::max(part.area(), Vec3(0.0));
        }
    }
    const Vec3 most = glm::max(up, down);
    glow.cover = std::min(1.0, std::max({most.x, most.y, most.z}) / kLeastCover);
    return glow;
}

Rgb emission_of(const GridMesh& grid, const MeshSurface& surface, const Vec3& middle,
                std::span<const uint32_t> touching, std::span<const uint32_t> glowing) {
    glm::dvec3 sum(0.0);
    Vec3 place(0.0);
    double area = 0.0;
    for (const uint32_t index : touching) {
        const GridTriangle& triangle = grid.triangles[index];
        if (!surface.emits(triangle)) continue;
        const ClippedTriangle part(corners_of(triangle), voxel_box(middle));
        const double size = glm::length(part.area());
        if (!(size > 0.0)) continue;
        const SurfacePoint at = part.middle();
        sum += size * glm::dvec3(surface.emission(triangle, at.barycentric, std::sqrt(size)));
        place += size * at.position;
        area += size;
    }
    if (!(area > 0.0)) return Rgb(0.0f);
    const Glow glow = glow_around(grid, surface, place / area, glowing);
    const double share = std::min(1.0, area / glow.area);
    return Rgb(sum / area * (glow.cover * (glow.cover + (1.0 - glow.cover) * share)));
}

}  // namespace

std::optional<VoxelLook> look_of(const GridMesh& grid, const MeshSurface& surface,
                                 const IVec3& voxel, std::span<const uint32_t> touching,
                                 std::span<const uint32_t> glowing) {
    const Vec3 middle = Vec3(voxel) + Vec3(0.5);
    const GridTriangle* nearest = nullptr;
    SurfacePoint point;
    double least = 0.0;
    for (const uint32_t index : touching) {
        const GridTriangle& triangle = grid.triangles[index];
        const std::array<Vec3, 3> corners = corners_of(triangle);
        if (surface.has_holes(triangle) &&
            !surface.is_any_there(triangle, ClippedTriangle(corners, voxel_box(middle)))) {
            continue;
        }
        const SurfacePoint its = nearest_point(corners, middle);
        const Vec3 gap = its.position - middle;
        const double distance2 = glm::dot(gap, gap);
        if (nearest != nullptr &&
            (distance2 > least || (distance2 == least && triangle.material >= nearest->material))) {
            continue;
        }
        nearest = &triangle;
        point = its;
        least = distance2;
    }
    if (nearest == nullptr) return std::nullopt;
    VoxelLook look{.albedo = surface.albedo(*nearest, point.barycentric, 1.0),
                   .distance = std::sqrt(least)};
    if (!glowing.empty()) look.emission = emission_of(grid, surface, middle, touching, glowing);
    return look;
}

}  // namespace probebake
