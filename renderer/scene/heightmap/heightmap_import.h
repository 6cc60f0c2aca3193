// A heightmap and its colours -> the voxels of a terrain.
//
// Columns of the picture run along +X, rows along +Z (a map with north on top has north at −Z).
// A column is round(count · height_scale_m / voxel_size_m) voxels high, at least one, above height
// 0; of these the ones that can be seen are made: from the top down to the top of the lowest of its
// four neighbours, so that neighbouring columns share a face and no ray passes between them.
// Heights that are real numbers may lie anywhere: there the lowest column has one voxel, below its
// height.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "scene/heightmap/height_exr.h"
#include "scene/picture/picture_file.h"
#include "voxels/voxel_cloud.h"

namespace probebake {

inline constexpr Rgb kBareHeightmapAlbedo{0.5f};

struct HeightmapParams {
    double height_scale_m = 1.0;  // per count or unit of the picture
    double voxel_size_m = 1.0;
    /// More is an IoError before it is allocated; 16 bytes each (8 GiB).
    uint64_t max_voxels = uint64_t{1} << 29;
};

/// Colours of the size of the heights, or none: grey. Throws IoError, naming `file_name`, for a
/// terrain that is higher than the tree can be, or that has more voxels than allowed.
VoxelCloud import_heightmap(const GreyPicture& heights, const std::optional<ColorPicture>& colors,
                            const HeightmapParams& params, const std::string& file_name);

struct Terrain {
    VoxelCloud cloud;
    IVec3 lowest{0};  // where its corner lies, voxels above height 0
};
Terrain import_heightmap(const HeightPicture& heights, const std::optional<ColorPicture>& colors,
                         const HeightmapParams& params, const std::string& file_name);

}  // namespace probebake
