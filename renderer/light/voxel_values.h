// One lit value per voxel, the thesis's lighting (Müller 2020): the mean over the voxel's exposed
// faces, averaged up the levels over the children that have one.
//
// It leaks by construction: a one-voxel wall with the sun outside shows the same value inside. It
// stands for comparisons; FaceColors has no such fault.
#pragma once

#include "light/face_colors.h"

namespace probebake {

/// Voxels without an exposed face, which no ray meets, are black.
ColorLevels one_value_per_voxel(const VoxelTree& tree, const FaceColors& faces);

}  // namespace probebake
