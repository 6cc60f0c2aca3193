// Whether voxels cover the surface that they were made of.
#pragma once

#include <cstdint>

#include "mesh/mesh_surface.h"
#include "voxels/voxel_tree.h"

namespace probebake {

struct PointCheck {
    uint64_t points = 0;
    uint64_t uncovered = 0;
};

/// Draws points on the triangles, as many per area everywhere (or per triangle, where none has an
/// area), and looks whether each that is no hole lies in a voxel; points within 1e-6 of a face may
/// lie in either.
PointCheck check_points(const GridMesh& grid, const MeshSurface& surface, const VoxelTree& tree,
                        uint64_t points);

/// Whether the point (voxels) lies in a voxel or within 1e-6 of one.
bool is_covered(const VoxelTree& tree, const Vec3& point);

}  // namespace probebake
