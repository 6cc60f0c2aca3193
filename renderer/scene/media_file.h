// The `media` of a scene file: what fills its air, read and checked but not loaded.
//
// Every element of the array has a type (homogeneous, fog, vdb, cumulus), coefficients per channel
// in 1/m at density 1, and a place in the world in metres; docs/scenes.md lists the fields. Grids
// are placed by scale, then a turn about +Y, then a shift.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/json.h"
#include "scene/generators/cumulus.h"
#include "volume/media.h"

namespace probebake {

struct VdbMediumFile {
    std::filesystem::path path;
    std::string grid;
    std::optional<std::string> emission_grid;
};

struct MediumFile {
    MediumSpec spec;  // of a grid: without it
    // At most one of these:
    std::optional<VdbMediumFile> vdb;
    std::optional<CumulusParams> cumulus;
    Affine place;  // from the grid's own space to the world, m
};

/// Reads the field `media`, which may be absent; file names are taken from `folder`. Problems go to
/// the reader's issues.
std::vector<MediumFile> read_media(ObjectReader& scene, const std::filesystem::path& folder);

/// Whether files of other programs are read for them.
bool has_grid_files(const std::vector<MediumFile>& files);

/// Decodes or generates the grids and keeps them as STEM.0.density and on (volume/grid_file.h).
/// Parallel on the calling arena. Throws IoError for files that are no densities.
void cache_grids(const std::vector<MediumFile>& files, const std::filesystem::path& stem);
void remove_cached_grids(const std::vector<MediumFile>& files, const std::filesystem::path& stem);

/// Reads or generates the grids and builds the octrees, in parallel on the calling arena; with
/// `stem`, from what cache_grids left there. Throws IoError for files that are no densities, and
/// where the cache does not have them whole.
Media load_media(const std::vector<MediumFile>& files,
                 const std::optional<std::filesystem::path>& stem = std::nullopt);

/// The box that holds all of them, m; its sides are infinite where one never ends. At least one.
Box extent_of(const Media& media);

}  // namespace probebake
