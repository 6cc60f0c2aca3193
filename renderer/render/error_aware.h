// Error-aware rendering of a pixel (Müller 2020, 5.1.3): 1 → 2×2 → leaf rays.
//
//   cast one ray at the level whose node covers the pixel
//   where E(node) > threshold: discard it, cast 2×2, one level finer, each with its own check
//   where E(node) > threshold again: discard that quadrant's ray, cast (g/2)² leaf rays in it
//
// With leaf_grid g = 4, the thesis's, a pixel casts at most 1 + 4 + 16 rays; g = 8 and 16 go on
// where the target asks for more. Every ray is counted, the discarded ones apart. A miss has no
// node, hence no error: it is refined only where threshold < 0, that is everywhere.
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

/// Rays that error_aware_pixel could cast in a pixel, so that the outcome of every threshold is
/// known without casting again: what the quality search works on.
struct RefinementRecord {
    struct Rays {
        Vec3 color{0.0};  // mean
        uint32_t steps = 0;
        uint32_t rays = 0;
    };
    struct Quadrant {
        Rays coarse;
        double error = 0.0;
        std::array<Rays, kLeafGrids.size()> leaves;  // empty for grids not cast
    };
    Rays first;
    double first_error = 0.0;
    std::array<Quadrant, 4> quadrants;
};

/// Casts the pixel's ray and its four quadrants'; counted in `stats`.
RefinementRecord record_refinement(const RenderScene& scene, const View& view, int x, int y,
                                   const RenderSettings& settings, CostStats& stats);

/// Adds the leaf rays of one of kLeafGrids.
void record_leaves(const RenderScene& scene, const View& view, int x, int y, int leaf_grid,
                   RefinementRecord& record, CostStats& stats);

/// Colour, rays (kept and discarded) and steps of error_aware_pixel at a threshold and a leaf grid
/// that was recorded.
RefinementRecord::Rays replay(const RefinementRecord& record, double threshold, int leaf_grid);

/// The same for the reference renderer with that leaf grid.
RefinementRecord::Rays replay_reference(const RefinementRecord& record, int leaf_grid);

}  // namespace probebake
