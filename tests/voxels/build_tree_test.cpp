#include <gtest/gtest.h>
#include "voxels/voxel_tree.h"
