// What the light of a tree will take, before it is computed.
#pragma once

#include <cstdint>

#include "voxels/voxel_tree.h"

namespace probebake {

/// Bytes of the FaceColors of a tree: exposed faces are counted in some 2,000 of its blocks of 16³
/// voxels, all of them where there are fewer. A matter of milliseconds, on the calling arena.
uint64_t expected_face_bytes(const VoxelTree& tree);

/// Bytes of one value per voxel (voxel_values.h): exact.
uint64_t voxel_value_bytes(const VoxelTree& tree);

}  // namespace probebake
