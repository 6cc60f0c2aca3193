// Light on disk, so that a state of a scene is lit once (io/checked_file.h has the format).
#pragma once

#include <filesystem>

#include "light/lighting.h"

namespace probebake {

/// Writes the faces' light and what it cost. Throws IoError.
void save_light(const std::filesystem::path& path, const LitScene& lit);

/// Reads what save_light wrote of this tree. Throws IoError for a damaged, truncated, foreign or
/// older file, and for one whose arrays do not fit together or are another tree's.
LitScene load_light(const std::filesystem::path& path, const VoxelTree& tree);

}  // namespace probebake
