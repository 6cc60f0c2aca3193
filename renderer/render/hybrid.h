// Hybrid rendering of a pixel: the visibility of the leaves, the colours of the level of detail.
//
// Every ray is traced to a voxel and shown with the mean colour of that voxel's ancestor at the
// level of its footprint, which lies on the ray's own path: what covers what is exact, what is far
// is prefiltered. (Müller 2020 stops the ray at that level, so that a node hides everything behind
// it; 6.1 and 6.2 of its outlook point this way.)
//
//   stage 0   1 ray through the pixel's middle; then, where it pays,
//   stage 1   4 more, in the middles of its quarters,
//   stage s   as many more as there are places left in a 2^s × 2^s grid whose cells hold one each
//             (owen_sobol): 16, 48, 192
//
// All rays of a pixel count, and its colour is their plain mean: none is cast to be thrown away. It
// pays where predicted error / rays of the next stage > price: error_model.h. The only thing a
// pixel knows of its neighbours is their first rays.
//
// Rays start at the nodes that can lie on their way (start_list.h): of the beam of a tile of
// pixels, found once, and, where 48 or more rays go through one pixel, of that pixel's own.
#pragma once

#include <span>

#include "render/error_model.h"
#include "render/pixel.h"

namespace probebake {

/// The hybrid renderer up to its last stage.
inline RenderSettings hybrid_at(double price) {
    return {.kind = RendererKind::kHybrid, .leaf_grid = 16, .price = price};
}
/// Whether every pixel gets all leaf rays that it can get: nothing is left to refine.
inline bool casts_all_leaf_rays(const RenderSettings& settings) {
    return settings.kind == RendererKind::kHybrid && settings.price <= 0.0 &&
           settings.least_grid == settings.leaf_grid;
}

/// Cells per pixel side of a stage.
constexpr int stage_grid(int stage) { return 1 << stage; }
/// Rays that a stage adds.
constexpr int stage_rays(int stage) {
    const int cells = stage_grid(stage) * stage_grid(stage);
    return stage < 3 ? cells : cells - cells / 4;
}

/// A pixel after `stage`; −1: before its first ray.
struct HybridPixel {
    int stage = -1;
    PixelSums sums;  // of weight 1 per ray
    CostStats cost;
    PixelEvidence evidence;

    Rgb color() const { return sums.scaled(1.0 / sums.samples).mean(); }
};

/// Where and with what a pixel's rays are cast.
struct HybridCast {
    const RenderScene& scene;
    const View& view;
    int x = 0;
    int y = 0;
    HybridSwitches switches;
    /// Of a beam that holds the pixel's; null: the root.
    const StartList* from = nullptr;
};

/// Casts the next stage.
void cast_stage(const HybridCast& cast, HybridPixel& pixel);

/// Mean squared difference of colour to the neighbours that there are, of a 3×3 block with the
/// pixel in its middle; 0 without any.
struct Neighbour {
    Rgb color{0.0f};
    bool there = false;
};
double neighbour_contrast(const std::array<Neighbour, 9>& block);
/// Of a pixel among a view's, given row by row.
double neighbour_contrast(std::span<const Neighbour> pixels, const View& view, int x, int y);

/// The squared error that is expected to be left after a pixel's last stage.
double expected_error(const HybridPixel& pixel);

/// Whether a pixel goes on after a stage. A price below 0 has every pixel go on to the last stage
/// that the settings' leaf grid allows.
bool goes_on(int stage, const PixelEvidence& evidence, const RenderSettings& settings);
/// What is compared with the price; 0 after the last stage.
double predicted_gain(int stage, const PixelEvidence& evidence);

/// A pixel of known contrast, from its first ray to its last.
PixelSums hybrid_pixel(const HybridCast& cast, double contrast, const RenderSettings& settings,
                       CostStats& stats);

/// The stages that a pixel goes through at some price, so that the outcome of any price from that
/// one up is known without casting again: what the quality search works on.
struct HybridRecord {
    struct Stage {
        Vec3 color{0.0};
        uint32_t rays = 0;  // up to this stage
        uint32_t steps = 0;
        double gain = 0.0;
        double predicted = 0.0;  // squared error that is left
        double seconds = 0.0;    // as far as whoever records says (record_stage does not)
    };
    std::array<Stage, kHybridStages> stages;
    HybridPixel pixel;

    int recorded() const { return pixel.stage + 1; }
    /// Of going on from the last recorded stage.
    double gain() const { return stages[static_cast<size_t>(pixel.stage)].gain; }
};
/// Casts the next stage; its cost alone is added to `stats`.
void record_stage(const HybridCast& cast, HybridRecord& record, CostStats& stats);
/// As the renderer would have it, from a record that holds the stages it goes through.
ReplayedPixel replay_hybrid(const HybridRecord& record, const RenderSettings& settings);

}  // namespace probebake
