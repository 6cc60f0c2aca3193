// A placed DensityGrid on disk, so that a file of another program is decoded once, and elsewhere
// (io/checked_file.h has the format).
#pragma once

#include <filesystem>

#include "math/affine.h"
#include "volume/density_grid.h"

namespace probebake {

struct PlacedGrid {
    DensityGrid grid;
    Affine index_to_world;
};

/// Throws IoError.
void save_grid(const std::filesystem::path& path, const DensityGrid& grid,
               const Affine& index_to_world);

/// Reads what save_grid wrote. Throws IoError for a damaged, truncated, foreign or older file, and
/// for one whose arrays do not fit together.
PlacedGrid load_grid(const std::filesystem::path& path);

}  // namespace probebake
