// SurfaceTriangles: what a scene keeps of its mesh, for questions about the sides of surfaces that
// voxels cannot answer.
//
// Triangles in grid units from the corner of the world (grid_mesh.h), 36 bytes each, fronts turning
// counter-clockwise. Those of materials that may have holes are left out: rays pass through them.
// Where no other has a back there is nothing to keep.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesh/grid_mesh.h"

namespace probebake {

struct SurfaceTriangles {
    std::vector<std::array<IVec3, 3>> triangles;
    uint64_t one_sided = 0;  // the first so many have a back; of the others both sides are fronts

    bool empty() const { return triangles.empty(); }
    uint64_t memory_bytes() const { return triangles.capacity() * sizeof(triangles[0]); }
};

SurfaceTriangles surface_triangles(const TriangleMesh& mesh, const GridMesh& grid);

}  // namespace probebake
