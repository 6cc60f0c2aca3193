// What part of its space a tree fills.
#pragma once

#include "math/affine.h"
#include "voxels/voxel_tree.h"

namespace probebake {

/// The smallest box (voxels) around all voxels; of an empty tree low > high.
Box filled_box(const VoxelTree& tree);

}  // namespace probebake
