// The product `ddgi`: the probes of a grid as RTXGI's irradiance and distance atlases.
//
// Every probe has a tile of each atlas (octahedral.h): 6 × 6 texels of irradiance and 14 × 14 of
// distance, each in a border of one. Probe (i, j, k) of a grid of Cx × Cy × Cz has the tile in
// column i + j Cx and row k: the horizontal planes of the grid side by side, from the lowest.
//
//   irradiance  R, G, B: E(n) / 2π, linear (RTXGI's encoding gamma 1; its shaders multiply by 2π).
//               A constant radiance L is L / 2.
//   distance    R: mean distance in metres of what is seen around the texel's direction, weighed by
//               cos^50; G: mean of its square. Rays that end farther than 1.5 |spacing|, or
//               nowhere, count as that far.
//
// Source: RTXGI-DDGI, docs/DDGIVolume.md and docs/Math.md (equation 7); docs/conventions.md.
#pragma once

#include <optional>
#include <span>

#include "bake/job_spec.h"
#include "bake/product_file.h"
#include "image/cubemap.h"
#include "image/exr.h"

namespace probebake {

inline constexpr int kDdgiIrradiance_px = 6;
inline constexpr int kDdgiDistance_px = 14;
inline constexpr int kDdgiBorder_px = 1;
/// Texels per side of a probe's tile.
constexpr int ddgi_tile_px(int inside_px) { return inside_px + 2 * kDdgiBorder_px; }

/// Of both atlases, uncompressed: RGB in HALF, two channels in FLOAT.
inline constexpr uint64_t kDdgiBytesPerProbe =
    6 * ddgi_tile_px(kDdgiIrradiance_px) * ddgi_tile_px(kDdgiIrradiance_px) +
    8 * ddgi_tile_px(kDdgiDistance_px) * ddgi_tile_px(kDdgiDistance_px);

/// What counts as the distance of all that is farther.
double ddgi_max_distance_m(const ProbeGrid& grid);

/// One probe's part of the atlases.
struct DdgiTile {
    Image irradiance;  // 8 × 8
    Image distance;    // 16 × 16; blue is not used
};
/// `distance`: per pixel the mean distance in red and its mean square in green, metres, rays cut
/// off at the grid's largest distance.
DdgiTile ddgi_tile(const Cubemap& radiance, const Cubemap& distance);

/// Tiles put together; `tiles` in the order of the grid's probes.
struct DdgiAtlas {
    Image irradiance;
    Image distance;
};
DdgiAtlas ddgi_atlas(const IVec3& counts, std::span<const DdgiTile* const> tiles);

/// The files of a grid in one lighting state.
struct GridResult {
    std::string grid;
    std::string state;
    bool is_float = false;  // a value did not fit into HALF
    std::vector<ProductFile> files;
};
/// `about`: what the headers say of scene, state and seed.
GridResult encode_ddgi(const ProbeGrid& grid, const DdgiAtlas& atlas, ProbeAttributes about);

}  // namespace probebake
