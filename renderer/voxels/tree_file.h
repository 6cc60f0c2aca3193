// A VoxelTree on disk, so that a large world is sorted once (checked_file.h has the format).
#pragma once

#include <filesystem>

#include "voxels/voxel_tree.h"

namespace probebake {

/// Writes the tree and its colours. Throws IoError.
void save_tree(const std::filesystem::path& path, const VoxelTree& tree);

/// Reads what save_tree wrote. Throws IoError for a damaged, truncated, foreign or older file, and
/// for one whose arrays do not fit together.
VoxelTree load_tree(const std::filesystem::path& path);

}  // namespace probebake
