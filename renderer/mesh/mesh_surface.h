// MeshSurface: what a point of a mesh looks like from a distance at which a footprint around it is
// one dot: factor times texture, filtered to the footprint, times the vertices' colours there.
#pragma once

#include <memory>
#include <vector>

#include "mesh/clipped_triangle.h"
#include "mesh/grid_mesh.h"
#include "mesh/texture_pyramid.h"

namespace probebake {

class MeshSurface {
  public:
    /// Keeps references. Makes pyramids in parallel on the calling arena. Throws
    /// std::invalid_argument for factors that are negative or not finite.
    MeshSurface(const TriangleMesh& mesh, const GridMesh& grid);

    /// Of a disc of that diameter (voxels) around a point. Of cut-outs: of what is there of it.
    Rgb albedo(const GridTriangle& triangle, const Vec3& barycentric, double footprint) const;
    Rgb emission(const GridTriangle& triangle, const Vec3& barycentric, double footprint) const;

    bool emits(const GridTriangle& triangle) const;
    bool shines_on_both_sides(const GridTriangle& triangle) const;
    bool has_holes(const GridTriangle& triangle) const;
    /// Whether a point is none of a hole.
    bool is_there(const GridTriangle& triangle, const Vec3& barycentric) const;
    /// Whether anything of a part of the triangle is. Parts of more than 8 texels are judged by the
    /// largest alpha of groups of texels: a speck is enough.
    bool is_any_there(const GridTriangle& triangle, const ClippedTriangle& part) const;

    /// At least the radiance of every point.
    float most_emission() const { return most_emission_; }
    uint64_t memory_bytes() const;

  private:
    const MeshMaterial& material(const GridTriangle& triangle) const {
        return mesh_.materials[triangle.material];
    }
    Vec2 uv(const GridTriangle& triangle, const Vec3& barycentric) const;
    glm::vec4 vertex_color(const GridTriangle& triangle, const Vec3& barycentric) const;
    Rgba texture_mean(const TexturePyramid& pyramid, const GridTriangle& triangle,
                      const Vec3& barycentric, double footprint) const;
    bool is_there_at_level(const GridTriangle& triangle, const Vec3& barycentric, int level) const;
    const TexturePyramid* base_pyramid(const MeshMaterial& of) const;

    const TriangleMesh& mesh_;
    std::vector<std::unique_ptr<TexturePyramid>> plain_;     // by texture; null where not needed
    std::vector<std::unique_ptr<TexturePyramid>> cut_outs_;  // the same
    float most_emission_ = 0.0f;
};

/// In voxels.
inline std::array<Vec3, 3> corners_of(const GridTriangle& triangle) {
    return {voxels_of(triangle.vertices[0]), voxels_of(triangle.vertices[1]),
            voxels_of(triangle.vertices[2])};
}

}  // namespace probebake
