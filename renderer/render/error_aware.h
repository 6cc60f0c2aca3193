// Error-aware rendering of a pixel (Müller 2020, 5.1.3): 1 → 2×2 → 4×4 rays, and further.
//
//   cast one ray at the level whose node covers the pixel
//   where E(node) > threshold: discard it, cast 2×2, one level finer, each with its own check
//   where E(node) > threshold again: discard that quadrant's ray, cast 2×2 leaf rays in it
//   so far the thesis: at most 1 + 4 + 16 rays. With leaf_grid 8 or 16 a refined pixel goes on:
//   where the rays of its mean spread more than `spread`: discard them, cast 8×8 leaf rays;
//   where these still do: 16×16
//
// Every ray is counted, the discarded ones apart. A miss has no node, hence no error: it is refined
// only where threshold < 0, that is everywhere.
#pragma once

#include "render/pixel.h"

namespace probebake {

/// E_N(r) of the node hit (5.1.4); 0 for a voxel and for a miss.
double hit_error(const RenderScene& scene, const Vec3& direction, const Hit& hit, double decay);

PixelSums error_aware_pixel(const RenderScene& scene, const View& view, int x, int y,
                            const RenderSettings& settings, CostStats& stats);

/// The two halves of error_aware_pixel, for renderers that decide on many pixels at once: the first
/// ray, not yet counted, and what replaces it where it is discarded.
struct FirstRay {
    Hit hit;
    Rgb color{0.0f};
    double error = 0.0;  // E_N of the node hit
};
FirstRay first_ray(const RenderScene& scene, const View& view, int x, int y,
                   const RenderSettings& settings);
PixelSums refine_pixel(const RenderScene& scene, const View& view, int x, int y,
                       const RenderSettings& settings, CostStats& stats);

/// Leaf grids that refinement may end in.
inline constexpr std::array<int, 3> kLeafGrids = {4, 8, 16};

/// Rays that error_aware_pixel could cast in a pixel, so that the outcome of all settings is known
/// without casting again: what the quality search works on.
struct RefinementRecord {
    struct Rays {
        Vec3 color{0.0};   // mean
        Vec3 square{0.0};  // mean of the squared colours
        uint32_t steps = 0;
        uint32_t rays = 0;
        uint32_t hits = 0;  // of these
    };
    struct Quadrant {
        Rays coarse;
        double error = 0.0;
        Rays leaves;  // 2×2
    };
    Rays first;
    double first_error = 0.0;
    std::array<Quadrant, 4> quadrants;
    /// grid × grid leaf rays of the whole pixel, by grid; empty where not recorded. The 4 × 4 ones
    /// are the quadrants' leaves.
    std::array<Rays, 17> grids;
};

/// Casts the first ray and the four quadrants'; counted in `stats`.
RefinementRecord record_refinement(const RenderScene& scene, const View& view, int x, int y,
                                   const RenderSettings& settings, CostStats& stats);

/// Adds grid × grid leaf rays, grid ≤ 16.
void record_leaves(const RenderScene& scene, const View& view, int x, int y, int leaf_grid,
                   RefinementRecord& record, CostStats& stats);

/// As error_aware_pixel would have it, from a record that holds the leaf grids of the settings.
ReplayedPixel replay_error_aware(const RefinementRecord& record, const RenderSettings& settings);

/// As the reference renderer with a leaf grid that was recorded.
ReplayedPixel replay_reference(const RefinementRecord& record, int leaf_grid);

/// Spread of the 4×4 leaf rays of a pixel, which is what `RenderSettings::spread` is compared with
/// where a pixel is refined throughout.
double leaf_spread(const RefinementRecord& record);

}  // namespace probebake
