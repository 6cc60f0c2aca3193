// What a voxel shows of the triangles that it touches.
//
// Albedo: that of the surface's point nearest to the voxel's middle, filtered to a footprint of one
// voxel. Where points of several triangles are equally near, the lower material counts, then the
// triangle that comes first in the GridMesh.
//
// Emission: the mean over what emits of the surface in the voxel, by area, so that lamps and bright
// texels smaller than a voxel are neither missed nor spread, times how much of the voxel they
// cover: the largest of the emitter's six projections along the axes, within a voxel's box around
// its middle, over 3/4 (a plane through the middle of a box covers at least that of it), 1 at most.
// So an extended emitter keeps its radiance and a small one its power, within a factor of two.
#pragma once

#include <optional>
#include <span>

#include "mesh/mesh_surface.h"

namespace probebake {

struct VoxelLook {
    Rgb albedo{0.0f};
    Rgb emission{0.0f};
    double distance = 0.0;  // of the surface from the voxel's middle, voxels
};

/// `touching`: triangles that overlap the voxel, in rising order. `glowing`: at least those that
/// emit within half a voxel of it, in rising order. None where all there is are holes.
std::optional<VoxelLook> look_of(const GridMesh& grid, const MeshSurface& surface,
                                 const IVec3& voxel, std::span<const uint32_t> touching,
                                 std::span<const uint32_t> glowing);

}  // namespace probebake
