// Scenes made for one question each: thin structures over flat ground, where error-aware
// refinement should pay (grating, net, canopy, slackline: Müller 2020, 3.2.2 and figure 3.7), one
// bright voxel (torch: 1.1), and single shapes. Built of 25 cm voxels; the ground's top is at
// y = size / 8 voxels.
#pragma once

#include <cstdint>

#include "voxels/voxel_cloud.h"

namespace probebake::worldgen {

inline constexpr double kStudyVoxel_m = 0.25;
inline constexpr Rgb kTorchRadiance{20000.0f, 11000.0f, 4000.0f};  // W·m⁻²·sr⁻¹

/// Panels of one-voxel bars, lying and upright. In x the gaps are 1, 2, 3 and 7 voxels wide, in z
/// the bars run along x, along z, diagonally, and crossed.
VoxelCloud make_grating(int size, uint64_t seed);
/// A sagging net of one-voxel ropes between posts, over boxes and balls.
VoxelCloud make_net(int size, uint64_t seed);
/// Three layers of scattered leaves on trunks.
VoxelCloud make_canopy(int size, uint64_t seed);
/// A one-voxel line between two trees, and three wires between poles.
VoxelCloud make_slackline(int size, uint64_t seed);
/// A wall that carries one strongly emissive voxel (kTorchRadiance), the only one of the world.
VoxelCloud make_torch(int size, uint64_t seed);

/// Hollow, three quarters of the world across.
VoxelCloud make_sphere(int size, uint64_t seed);
/// Hollow, half of the world across.
VoxelCloud make_box(int size, uint64_t seed);
/// One layer of voxels at y = size / 4.
VoxelCloud make_plane(int size, uint64_t seed);
/// Sixteen steps that rise along x to half the world's height.
VoxelCloud make_stairs(int size, uint64_t seed);
/// One voxel, at (size / 2, size / 2, size / 2).
VoxelCloud make_single(int size, uint64_t seed);

}  // namespace probebake::worldgen
