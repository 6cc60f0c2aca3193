// Rays against the triangles themselves, through an object octree: what voxels are compared with.
#pragma once

#include <algorithm>
#include <vector>

#include "math/random.h"
#include "mesh/mesh_surface.h"
#include "mesh/surface_check.h"
#include "mesh/triangle_box.h"
#include "mesh/voxelise.h"
#include "objects/object_octree.h"
#include "voxels/trace.h"

namespace probebake::test {

/// The triangles of a GridMesh, in voxels.
class MeshRays {
  public:
    explicit MeshRays(const GridMesh& grid) : set_(set_of(grid)), octree_(make_octree(set_)) {}

    MeshRays(const MeshRays&) = delete;
    MeshRays& operator=(const MeshRays&) = delete;

    ObjectHit closest_hit(const Ray& ray, const TRange& range = {}) const {
        return octree_.closest_hit(ray, range);
    }
    ObjectHit closest_hit(const Ray& ray, const TRange& range, OctreeTraversal how,
                          CastCounts& counts) const {
        return octree_.closest_hit(ray, range, how, counts);
    }
    const ObjectSet& set() const { return set_; }

    Vec3 barycentric(uint32_t triangle, const Vec3& point) const {
        const Triangle& t = set_.triangles()[triangle];
        return nearest_point({t.a, t.b, t.c}, point).barycentric;
    }

  private:
    static ObjectSet set_of(const GridMesh& grid) {
        ObjectSet set;
        for (const GridTriangle& t : grid.triangles) {
            const std::array<Vec3, 3> p = corners_of(t);
            set.add(Triangle{p[0], p[1], p[2]});
        }
        return set;
    }
    static ObjectOctree make_octree(const ObjectSet& set) {
        int depth = 3;
        while ((size_t{1} << (2 * depth)) < set.size() && depth < 10) ++depth;
        return {set, safe_boxes(set), {.max_depth = depth, .most_items = 8}};
    }

    ObjectSet set_;
    ObjectOctree octree_;
};

struct RayCheck {
    uint64_t hits = 0;
    uint64_t outside = 0;  // of these, in no voxel
    /// Of the others: what the ray sees where it hits, filtered to a voxel, beside the voxel's own
    /// albedo, which is that of the surface nearest to its middle. Largest channel, 0 to 1.
    double albedo_difference = 0.0;  // summed
    uint64_t same_albedo = 0;        // within 1/32
    uint64_t emissive_hits = 0;
    uint64_t dark_voxels = 0;             // of these, in a voxel that emits nothing
    uint64_t emissive_voxels_unseen = 0;  // hits that emit nothing, in one that does
};

/// Rays along the axes through the middles of voxels, as the thesis made its data: every hit with
/// the surface, holes left out, is looked up in the tree.
inline RayCheck check_axis_rays(const GridMesh& grid, const MeshSurface& surface,
                                const MeshRays& rays, const VoxelTree& tree, uint64_t count) {
    RayCheck check;
    for (uint64_t i = 0; i < count; ++i) {
        RandomStream random(random_key({0x61786973, i}));
        Ray ray{.origin = Vec3(0.5), .direction = Vec3(0.0)};
        const int axis = static_cast<int>(i % 3);
        for (int a = 0; a < 3; ++a) {
            ray.origin[a] +=
                static_cast<double>(random.below(static_cast<uint64_t>(grid.extent[a])));
        }
        ray.origin[axis] = -1.0;
        ray.direction[axis] = 1.0;
        for (double from = 0.0;;) {
            const ObjectHit hit = rays.closest_hit(ray, {.begin = from});
            if (!hit) break;
            from =
                hit.t + 1e-9;  // a ray is brought to the scene and back: the same hit would return
            const Vec3 at = ray.origin + hit.t * ray.direction;
            const GridTriangle& triangle = grid.triangles[hit.object];
            if (!surface.is_there(triangle, rays.barycentric(hit.object, at))) continue;
            ++check.hits;
            if (!is_covered(tree, at)) ++check.outside;
            const auto voxel = tree.find_voxel(IVec3(glm::floor(at)));
            if (!voxel) continue;  // on the border of one
            const Vec3 barycentric = rays.barycentric(hit.object, at);
            const ColorPyramid& colors = tree.colors();
            const Rgb seen = glm::clamp(surface.albedo(triangle, barycentric, 1.0), 0.0f, 1.0f);
            const Rgb gap = glm::abs(seen - unpack_rgb(colors.albedo.voxels[*voxel]));
            const float most = std::max({gap.r, gap.g, gap.b});
            check.albedo_difference += static_cast<double>(most);
            if (most <= 1.0f / 32.0f) ++check.same_albedo;
            const bool glows = !colors.emission.empty() && colors.emission.voxels[*voxel] != 0;
            const bool shines = surface.emission(triangle, barycentric, 1.0) != Rgb(0.0f);
            if (shines) ++check.emissive_hits;
            if (shines && !glows) ++check.dark_voxels;
            if (!shines && glows) ++check.emissive_voxels_unseen;
        }
    }
    return check;
}

/// How a mesh and its voxels agree on where rays end. Rays start in the air, anywhere; of those
/// that end in either.
struct Agreement {
    uint64_t rays = 0;
    uint64_t behind = 0;  // the voxel's hit lies behind the mesh's, or is missing: never
    /// Both end within a voxel's diagonal of what ends the other: the surface of the mesh is that
    /// near to the voxel's hit, and the mesh's hit lies in a voxel.
    uint64_t agree = 0;
    uint64_t along = 0;  // the hits are within a diagonal of each other, along the ray
    uint64_t past = 0;   // the voxels are hit, and the mesh is passed altogether
    /// The triangle that is hit touches the very voxel that is hit; the others have passed an edge
    /// of what made that voxel. And of these, those within a diagonal over the cosine of incidence
    /// along the ray: all.
    uint64_t same_surface = 0;
    uint64_t within_cosine = 0;
    /// Of those that meet the mesh at 60° to its surface or more: all, and those within a diagonal.
    uint64_t steep = 0;
    uint64_t steep_along = 0;

    double share(uint64_t of) const { return static_cast<double>(of) / static_cast<double>(rays); }
};

/// Distance of a point from the nearest triangle, none if that is more than `most` (voxels).
inline bool is_near_surface(const MeshRays& rays, const Vec3& point, double most) {
    const Box around = grown(Box{point, point}, most);
    const std::vector<Triangle>& triangles = rays.set().triangles();
    return std::any_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
        if (!overlap_closed(around, join(join(Box{t.a, t.a}, t.b), t.c))) return false;
        return glm::distance(nearest_point({t.a, t.b, t.c}, point).position, point) <= most;
    });
}

inline Agreement compare(const TriangleMesh& mesh, double voxel_size_m, uint64_t count,
                         uint64_t seed) {
    constexpr double kDiagonal = 1.7320508075688772;
    constexpr double kSteepCosine = 0.8660254037844386;
    const VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = voxel_size_m});
    const GridMesh grid = make_grid_mesh(mesh, voxel_size_m);
    const MeshSurface surface(mesh, grid);
    const MeshRays rays(grid);
    Agreement agreement;
    for (uint64_t i = 0; agreement.rays < count && i < 20 * count; ++i) {
        RandomStream random(random_key({0x6167726565, seed, i}));
        const Vec3 origin =
            Vec3(random.uniform(), random.uniform(), random.uniform()) * Vec3(grid.extent);
        const double z = 2.0 * random.uniform() - 1.0;
        const double angle = 6.283185307179586 * random.uniform();
        const double r = std::sqrt(1.0 - z * z);
        const Ray ray{origin, {r * std::cos(angle), r * std::sin(angle), z}};
        if (made.tree.occupied(IVec3(glm::floor(origin)))) continue;
        const auto at = [&](double t) { return ray.origin + t * ray.direction; };
        ObjectHit hit;
        do {
            hit = rays.closest_hit(ray, {.begin = hit ? hit.t + 1e-9 : 0.0});
        } while (hit && !surface.is_there(grid.triangles[hit.object],
                                          rays.barycentric(hit.object, at(hit.t))));
        const Hit voxel = trace(made.tree, ray);
        if (!hit && !voxel) continue;
        ++agreement.rays;
        if (hit && !(hit.t - voxel.t >= -1e-6)) {
            ++agreement.behind;
            continue;
        }
        if (!hit) ++agreement.past;
        if (hit) {
            const double gap = hit.t - voxel.t;
            const Vec3 normal = normal_at(rays.set(), hit.object, at(hit.t));
            const double cosine = std::abs(glm::dot(normal, ray.direction));
            if (gap <= kDiagonal) ++agreement.along;
            const TriangleBox triangle(grid.triangles[hit.object].vertices);
            if (triangle.overlaps(voxel.corner * kGridUnits, kGridUnits)) {
                ++agreement.same_surface;
                if (gap * cosine <= kDiagonal + 1e-6) ++agreement.within_cosine;
            }
            if (cosine >= kSteepCosine) ++agreement.steep;
            if (cosine >= kSteepCosine && gap <= kDiagonal) ++agreement.steep_along;
        }
        if (is_near_surface(rays, at(voxel.t), kDiagonal + 1e-6) &&
            (!hit || is_covered(made.tree, at(hit.t)))) {
            ++agreement.agree;
        }
    }
    return agreement;
}

}  // namespace probebake::test
