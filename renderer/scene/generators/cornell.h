// The test scene of Müller 2020, 3.2.2: a box of 32³ voxels with a light at its back and a grating
// of one-voxel bars and gaps at its front, standing on a floor that its beam falls on.
//
// Positions are voxels and the same at every size of the world (1024 and up); ranges are [min,
// max). The floor's top is the plane y = 256, which is a node boundary at every level up to 2^8, so
// that no coarser level of detail raises it. Every cell of 2³ voxels of the front holds a bar and a
// gap: one level up, the grating is a closed wall.
#pragma once

#include "voxels/voxel_cloud.h"

namespace probebake::cornell {

inline constexpr int kMinWorld = 1024;
inline constexpr int kFloorY = 255;  // the floor's voxels, over the whole world
inline constexpr IVec3 kBoxMin{256, 256, 256};
inline constexpr IVec3 kBoxMax{288, 288, 288};    // walls one voxel thick, all faces but the front
inline constexpr int kGratingZ = 287;             // upright bars at even x, gaps at odd x
inline constexpr IVec3 kLightMin{268, 268, 257};  // a panel in front of the back wall
inline constexpr IVec3 kLightMax{276, 276, 258};
inline constexpr Rgb kLightRadiance{2000.0f, 1900.0f, 1700.0f};  // W·m⁻²·sr⁻¹
inline constexpr Rgb kFloorAlbedo{0.5f, 0.5f, 0.5f};
/// Where the beam falls: x and z of the floor that is looked at.
inline constexpr IVec3 kFloorRegionMin{192, kFloorY, 290};
inline constexpr IVec3 kFloorRegionMax{352, kFloorY + 1, 890};

}  // namespace probebake::cornell

namespace probebake::worldgen {

VoxelCloud make_cornell(int size, uint64_t seed);

}  // namespace probebake::worldgen
