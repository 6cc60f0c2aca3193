// The adaptive renderer (Müller 2020, 5.1.2): refine where the one-ray image varies.
//
//   variation = Σ (L − mean L)² over the 3×3 neighbours of the one-ray image, L their luminance;
//               pixels whose ray missed are left out (or count as black: MissesInKernel)
//   variation / normaliser ≥ 0.75: replaced by 4×4 leaf rays; ≥ 0.25: by 2×2 leaf rays
//
// One iteration. The first ray stays counted as a discarded ray where its pixel is refined. The
// thesis normalises over its four data sets, which are not public: the normaliser is a parameter.
#pragma once

#include <span>
#include <vector>

#include "render/pixel.h"

namespace probebake {

inline constexpr double kAdaptiveTwoByTwo = 0.25;
inline constexpr double kAdaptiveFourByFour = 0.75;

/// The one-ray image of a rectangle of pixels.
struct OneRayPixel {
    float luminance = 0.0f;
    bool rendered = false;  // false: not part of the image (owned by another face)
    bool hit = false;
};

/// Variation of pixel (x, y) of a width × height image; 0 where no neighbour counts.
double luminance_variation(std::span<const OneRayPixel> pixels, int width_px, int height_px, int x,
                           int y, MissesInKernel misses);

/// Leaf rays per pixel side that a variation asks for: 0 (keep the first ray), 2 or 4.
int adaptive_grid(double variation, double normaliser);

/// Rays that pixels of these variations cost, first rays included.
uint64_t adaptive_rays(std::span<const double> variations, double normaliser);

/// The normaliser with which pixels of these variations cost at most `rays` in all (first rays
/// included), as many of them as fit. Infinity where `rays` allows no refinement at all.
double solve_normaliser(std::vector<double> variations, uint64_t rays);

}  // namespace probebake
