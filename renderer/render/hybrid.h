// Hybrid rendering of a pixel: the visibility of the leaves, the colours of the level of detail.
//
// Every ray is traced to a voxel and shown with the mean colour of that voxel's ancestor at the
// level of its footprint, which lies on the ray's own path: what covers what is exact, what is far
// is prefiltered. (Müller 2020 stops the ray at that level, so that a node hides everything behind
// it; 6.1 and 6.2 of its outlook point this way.)
//
//   stage 0   1 ray; then, where it pays,
//   stage 1   2×2 rays, stage 2 4×4, stage 3 8×8, stage 4 16×16, each in place of the one before
//
// It pays where predicted error / steps of the stage > price: error_model.h. All rays count, those
// of replaced stages as discarded. The only thing a pixel knows of its neighbours is their first
// rays.
#pragma once

#include "render/error_model.h"
#include "render/pixel.h"

namespace probebake {

/// Rays per pixel side of a stage.
constexpr int stage_grid(int stage) { return 1 << stage; }

/// One stage of a pixel: its rays, and what they add to the evidence.
struct HybridStage {
    PixelSums sums;
    CostStats cost;
    double node_error = 0.0;  // of stages 0 and 1
    double child_variance = 0.0;
    double passed_contrast = 0.0;
    double ray_variance = 0.0;
    int8_t level = -1;  // shown by the last ray; −1 for a miss
};
HybridStage hybrid_stage(const RenderScene& scene, const View& view, int x, int y, int stage);

/// Adds what a stage found.
void add_evidence(PixelEvidence& evidence, int stage, const HybridStage& found);

/// Mean squared difference of colour to the neighbours that there are, of a 3×3 block with the
/// pixel in its middle; 0 without any.
struct Neighbour {
    Rgb color{0.0f};
    bool there = false;
};
double neighbour_contrast(const std::array<Neighbour, 9>& block);

/// Whether a pixel goes on after a stage. A price below 0 has every pixel go on to the last stage
/// that the settings' leaf grid allows.
bool goes_on(int stage, const PixelEvidence& evidence, uint64_t stage_steps,
             const RenderSettings& settings);
/// What is compared with the price.
double predicted_gain(int stage, const PixelEvidence& evidence, uint64_t stage_steps);

/// A pixel of known contrast, from its first ray to its last.
PixelSums hybrid_pixel(const RenderScene& scene, const View& view, int x, int y, double contrast,
                       const RenderSettings& settings, CostStats& stats);

/// All stages that a pixel could go through, so that the outcome of any price is known without
/// casting again: what the quality search works on.
struct HybridRecord {
    struct Stage {
        Vec3 color{0.0};
        uint32_t rays = 0;
        uint32_t steps = 0;
        double gain = 0.0;
    };
    std::array<Stage, kHybridStages> stages;
    int recorded = 0;
    PixelEvidence evidence;
};
/// Casts the next stage.
void record_stage(const RenderScene& scene, const View& view, int x, int y, HybridRecord& record,
                  CostStats& stats);
/// As the renderer would have it, from a record that holds the stages up to the settings' leaf
/// grid.
ReplayedPixel replay_hybrid(const HybridRecord& record, const RenderSettings& settings);

}  // namespace probebake
