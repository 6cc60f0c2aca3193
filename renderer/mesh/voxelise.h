// voxelise: a mesh becomes a VoxelTree.
//
// A voxel is there where a triangle touches it, both closed and decided exactly (triangle_box.h),
// and where what touches it is no hole. So the voxels of a closed surface keep what is inside apart
// from what is outside, even for paths across edges and corners of voxels, however the surface is
// turned and though its walls have no thickness.
//
// The world is split down to blocks of 64³ voxels, each with its triangles; blocks are voxelised in
// parallel and appended to the tree in Morton order, so that besides the tree and the mesh only a
// few blocks are held at a time. The result is the same for any number of threads, and for any
// order of the mesh's triangles and vertices.
#pragma once

#include <cstdint>
#include <optional>

#include "mesh/surface_triangles.h"
#include "mesh/triangle_mesh.h"
#include "voxels/voxel_tree.h"

namespace probebake {

struct VoxeliseParams {
    double voxel_size_m = 1.0;
    /// Where voxel (0, 0, 0) begins; by default as in grid_mesh.h.
    std::optional<Vec3> corner_m;
    /// Whether what the surface closes in becomes voxels, too (voxels/solid_fill.h).
    bool solid = false;
    uint64_t max_voxels = uint64_t{1} << 31;
    uint64_t max_memory_bytes = uint64_t{16} << 30;
    /// Points of the surface of which it is checked that they lie in a voxel.
    uint64_t checked_points = 100'000;
};

struct VoxeliseReport {
    uint64_t triangles = 0;
    uint64_t voxels = 0;
    uint64_t filled_voxels = 0;  // of these, not on the surface
    double seconds = 0.0;
    uint64_t peak_bytes = 0;  // largest sum of its own buffers, the mesh not included
    /// Of points drawn on the surface (by area, not in holes): how many were looked at, and how
    /// many lay in no voxel.
    uint64_t checked_points = 0;
    uint64_t uncovered_points = 0;
    /// The Hausdorff distance between surface and voxels (but for filled ones) is at most this: no
    /// point of a voxel is farther than half its diagonal from its middle, and the surface from the
    /// middle is measured for every voxel. Infinite where a point is uncovered.
    double hausdorff_m = 0.0;
    double voxel_diagonal_m = 0.0;
};

struct VoxelisedMesh {
    VoxelTree tree;
    SurfaceTriangles surface;
    Vec3 corner_m{0.0};
    VoxeliseReport report;
};

/// Parallel on the calling arena. Throws std::invalid_argument where the mesh does not fit the grid
/// or more voxels or memory would be needed than allowed.
VoxelisedMesh voxelise(const TriangleMesh& mesh, const VoxeliseParams& params);

}  // namespace probebake
