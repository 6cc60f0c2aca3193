// The search for the cheapest settings that meet a target, on a sample of pixels.
//
// Every pixel of the sample carries the rays that any candidate could cast in it, and two estimates
// of its truth. A candidate's colour, rays, steps and error then follow without casting again, so
// that hundreds of thresholds can be compared; cost is counted in steps, never in seconds.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "bake/quality.h"
#include "render/error_aware.h"
#include "render/hybrid.h"

namespace probebake {

/// A pixel of the sample.
struct SearchPixel {
    double weight = 1.0;  // of its error; mean 1 over the sample
    TruthPair truth;
    RefinementRecord record;
    HybridRecord hybrid;
    double variation = 0.0;  // of the adaptive renderer's 3×3 kernel
};

struct SearchSample {
    std::vector<SearchPixel> pixels;
    /// Pixels come as whole windows of SSIM, 121 in a row each; without, one by one.
    bool windows = false;
    double exposure = 1.0;
};

/// Colour, rays and steps of a pixel under some settings.
ReplayedPixel replay(const SearchPixel& pixel, const RenderSettings& settings);

struct Candidate {
    RenderSettings settings;
    double rays_per_pixel = 0.0;
    double steps_per_pixel = 0.0;
    MeasuredError error;
};
Candidate evaluate(const SearchSample& sample, const RenderSettings& settings);

/// Error of given colours on the sample.
MeasuredError measure(const SearchSample& sample, const std::vector<Rgb>& colors);

/// Leaf grids of every pixel that are worth comparing below the reference's 4 × 4, where the plan
/// is free to choose.
inline constexpr std::array<int, 3> kCoarseGrids = {1, 2, 3};

/// Settings worth comparing with the leaf grids up to `max_leaf_grid`: thresholds, spreads and
/// normalisers at quantiles of what the sample shows, from no refinement to all. Not for the hybrid
/// renderer.
std::vector<RenderSettings> candidate_settings(const SearchSample& sample,
                                               const std::vector<RendererKind>& renderers,
                                               int max_leaf_grid);

/// The hybrid renderer at prices from `lowest` up, at quantiles of the gains that the sample shows.
std::vector<RenderSettings> hybrid_settings(const SearchSample& sample, double lowest);

/// Settings that refine more and more, on from the last that the sample speaks for: for a probe
/// that misses the target although the sample met it. Not for the hybrid renderer.
std::vector<RenderSettings> finest_settings(const std::vector<RendererKind>& renderers);

/// The candidates that no other beats in both steps and error, cheapest first.
std::vector<Candidate> frontier(std::vector<Candidate> candidates, const QualityTarget& target);

}  // namespace probebake
