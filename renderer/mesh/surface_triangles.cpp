#include "mesh/surface_triangles.h"

namespace probebake {

SurfaceTriangles surface_triangles(const TriangleMesh& mesh, const GridMesh& grid) {
    SurfaceTriangles surface;
    const auto add = [&](bool double_sided) {
        for (const GridTriangle& triangle : grid.triangles) {
            const MeshMaterial& material = mesh.materials[triangle.material];
            if (material.alpha_cutoff > 0.0f || material.double_sided != double_sided) continue;
            surface.triangles.push_back(triangle.vertices);
        }
    };
    add(false);
    surface.one_sided = surface.triangles.size();
    if (surface.one_sided > 0) add(true);
    surface.triangles.shrink_to_fit();
    return surface;
}

}  // namespace probebake
