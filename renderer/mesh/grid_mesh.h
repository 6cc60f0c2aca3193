// GridMesh: the triangles of a mesh on the grid of the voxels that they are to become.
//
// Vertices are rounded once, to 1/4096 of a voxel, and are integers from there on: what is asked
// about them has exact answers (triangle_box.h), and surfaces that share vertices stay closed.
// Triangles stand in an order of their own, by place, texture coordinates, colours and material,
// each turned so that its lowest vertex comes first: nothing made of them depends on the order of
// triangles or vertices in the file.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "mesh/triangle_mesh.h"

namespace probebake {

inline constexpr int kGridUnitsLog2 = 12;
inline constexpr int kGridUnits = 1 << kGridUnitsLog2;  // per voxel

/// From grid units to voxels.
inline Vec3 voxels_of(const IVec3& units) { return Vec3(units) / static_cast<double>(kGridUnits); }

struct GridTriangle {
    std::array<IVec3, 3> vertices;      // grid units from the corner of the world, ≥ 0
    std::array<uint32_t, 3> corners{};  // the same vertices in the mesh
    uint32_t material = 0;
};

struct GridMesh {
    std::vector<GridTriangle> triangles;
    Vec3 corner_m{0.0};  // of the world
    double voxel_size_m = 1.0;
    IVec3 extent{0};  // voxels from the corner on that hold everything
};

/// `corner_m`: where voxel (0, 0, 0) begins; by default half a voxel below the last multiple of the
/// voxel size before the mesh, so that what is modelled on the grid lies in the middle of voxels
/// and not on both sides of a plane. Throws std::invalid_argument where positions are not finite,
/// lie before the corner or need more than 65,536 voxels per axis.
GridMesh make_grid_mesh(const TriangleMesh& mesh, double voxel_size_m,
                        const std::optional<Vec3>& corner_m = std::nullopt);

}  // namespace probebake
