// fill_solid: the air of a world that nothing outside can reach becomes voxels.
//
// Air is connected through faces of voxels. Filled is what has no way to the border of the world,
// or beyond it: the inside of closed shells, rooms in them too. A shell with an opening of a voxel
// or more stays hollow. The flood goes over the empty cells of the tree, the largest there are, so
// that its work grows with the surface and not with the volume; what is filled takes 4 bytes a
// voxel and colour like any other.
//
// A filled voxel has the albedo of the voxel before it in Morton order and emits nothing.
#pragma once

#include "voxels/voxel_tree.h"

namespace probebake {

struct SolidFill {
    VoxelTree tree;
    uint64_t filled = 0;  // voxels that were not there before
};

/// Throws std::invalid_argument where the tree would have more than `max_voxels`.
SolidFill fill_solid(VoxelTree tree, uint64_t max_voxels);

}  // namespace probebake
