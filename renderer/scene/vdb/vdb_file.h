// Density grids out of OpenVDB files.
//
// Any float or double grid of an OpenVDB file (half-float and blosc-compressed ones too), active or
// not, tiles included, with an affine transform. What is no density (NaN, infinite, negative
// values, a background other than 0, a level set, a perspective map, extents beyond DensityGrid's)
// is an IoError that names the grid. Builds without OpenVDB refuse every file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/io_error.h"
#include "math/affine.h"
#include "volume/density_grid.h"

namespace probebake {

struct VdbGrid {
    DensityGrid grid;
    Affine index_to_world;
    uint64_t active_voxels = 0;  // tiles count as their voxels
    uint64_t active_tiles = 0;
};

/// Whether this build reads OpenVDB files.
bool reads_vdb();

/// The grid of that name. Parallel on the calling arena. Throws IoError.
VdbGrid read_vdb_grid(const std::filesystem::path& path, const std::string& grid_name);

/// Names of all grids in a file, whatever their types. Throws IoError.
std::vector<std::string> vdb_grid_names(const std::filesystem::path& path);

}  // namespace probebake
