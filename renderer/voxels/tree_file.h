// A VoxelTree on disk, so that a large world is sorted once (checked_file.h has the format).
#pragma once

#include <filesystem>
#include <string>

#include "voxels/voxel_tree.h"

namespace probebake {

struct TreeFile {
    VoxelTree tree;
    std::string notes;  // whatever the writer wants back
};

/// Writes the tree, its colours and the notes. Throws IoError.
void save_tree(const std::filesystem::path& path, const VoxelTree& tree,
               const std::string& notes = {});

/// Reads what save_tree wrote. Throws IoError for a damaged, truncated, foreign or older file, and
/// for one whose arrays do not fit together.
TreeFile load_tree(const std::filesystem::path& path);

}  // namespace probebake
