// The audit: how wrong a rendered cubemap is, measured on fresh pixels.
//
// Stored pixels are drawn with replacement with probabilities p: half without, half in proportion
// to a predicted squared error (the hybrid renderer's own; of others contrast with the neighbours,
// divided by the rays kept) and to what may be hidden (hidden_light.h), a quarter each where there
// is both; all over the root of what auditing the pixel costs. Each is compared,
// as the written file holds it, with two independent means r1, r2 of stratified leaf rays, so many
// that they are about as noisy as the pixel is wrong: about 1.1 √rays a side for a pixel of so many
// rays. e = weight · (a − r1)(a − r2) / (N p) is an unbiased estimate of the mean squared error
// (Horvitz-Thompson), and the mean of n of them has the interval of estimate.h. The first half
// bounds 1/(N p), wherever the prediction is wrong. SSIM is audited on whole windows, drawn
// uniformly, and only where it is the target.
// The same draws tell how wrong the spherical harmonics are (sh_audit.h): by themselves, for which
// it takes many, or, where pixels err without bias and independently, by what their errors are then
// expected to add up to (irradiance_noise.h).
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "bake/error_prior.h"
#include "bake/irradiance_noise.h"
#include "bake/quality.h"
#include "bake/sh_audit.h"
#include "image/cubemap.h"
#include "render/render.h"

namespace probebake {

struct Audit {
    MeasuredError error;
    uint64_t pixels = 0;
    uint64_t windows = 0;
    bool by_lot = false;     // drawn as the lot fell: tells of the job, too little of the probe
    double predicted = 0.0;  // mean squared error by the renderer's own prediction; 0 without one
    double chance = 0.0;     // relative standard deviation of the error about it: of few pixels
    std::optional<ShAudit> sh;
    std::optional<IrradianceNoise> noise;  // by its own variances, of paths
    std::optional<double> ssim_lost;       // by the same (render_noise.h)
    CostStats cost;
};

/// Two independent estimates of the truth of an owner pixel, of grid × grid rays each, from the
/// random stream of that key.
using TruthOf =
    std::function<TruthPair(const CubePixel& owner, int grid, uint64_t key, CostStats& stats)>;
/// Of voxels alone (truth_pair), for a probe at `origin` (voxels) with faces of n pixels. The scene
/// outlives it.
TruthOf voxel_truth(const RenderScene& scene, const Vec3& origin, int n,
                    Against against = Against::kTruth);

/// What is audited and how.
struct AuditSpec {
    TruthOf truth;
    const Cubemap& as_written;
    std::span<const PixelAux> aux;
    /// Squared errors per stored pixel that the rays of the render do not tell of; or none.
    std::span<const double> hidden = {};
    double exposure = 1.0;
    /// Of all that the state may show: what a pixel that looks right may be wrong by.
    double largest_radiance = 0.0;
    /// Whether the truth is the 4 × 4 reference, of 16 rays whatever the grid.
    bool reference_rays = false;
    /// Rays per side of r1 and r2; none: as many as each pixel needs, at most the largest.
    std::optional<int> truth_grid;
    int largest_truth_grid = kTruthGrids.back();
    Weighting weighting = Weighting::kUniform;
    /// Draws; none: as many as `rays` pay for, within the bounds.
    std::optional<int> pixels;
    double rays = 0.0;
    int least_pixels = 0;
    int most_pixels = 0;
    /// Where others of the job tell as well: where the rays do not pay for `least_pixels`, as many
    /// as they pay for on average over the lots (audit_size.h), in pairs; none at all in most.
    std::optional<double> lot;
    int windows = 0;                        // of SSIM
    int window_grid = kTruthGrids.front();  // rays per side of r1 and r2 in them
    bool rel_mse = false;
    bool sh = false;  // whether the spherical harmonics are audited, too
    /// What variances of pixels lead to expect, where these err independently and without bias.
    std::optional<IrradianceNoise> noise;
    std::optional<double> ssim_lost;
    /// Draws pixels for them, by solid angle and predicted error instead of its square: best for a
    /// sum in which errors of different pixels cancel.
    bool drawn_for_sh = false;
    uint64_t key = 0;  // of its random streams: a fresh one for every look
};

/// What an audit says beside the renderer's prediction, in the metric's size (error_size): without
/// draws where windows of SSIM were spared, none where nothing is predicted or measured.
std::optional<AuditedRatio> audited_ratio(QualityTarget::Metric metric, const Audit& audit);

/// Runs on the calling arena; the same for any number of threads. Throws Cancelled.
Audit audit_cubemap(const AuditSpec& spec, const CancelToken& cancel);

}  // namespace probebake
