// Errors measured against the truth, and whether they meet a target.
//
// The truth of a pixel is the mean leaf-level radiance over its footprint. It is never known
// exactly: two independent stratified means r1, r2 of it make (a − r1)(a − r2) an unbiased estimate
// of the squared error of a value a (docs/conventions.md, "Audited error").
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "bake/job_spec.h"
#include "math/estimate.h"
#include "math/norm_estimate.h"
#include "render/pixel.h"

namespace probebake {

/// Two independent estimates of what a pixel is measured against; equal where that is exact.
struct TruthPair {
    Rgb r1{0.0f};
    Rgb r2{0.0f};
};

/// Leaf rays per side of one estimate of the truth: as few as the target lets pass, because the
/// noise of r1 and r2 hides errors that are much smaller (PilotSample).
inline constexpr std::array<int, 3> kTruthGrids = {4, 8, 16};
/// The same for irradiance and an image of grid × grid leaf rays. Where stratified means have a
/// variance like grid⁻³, 0.63 of the image's grid tells most for its rays: the truth then is about
/// as noisy as the image is wrong.
constexpr int irradiance_truth_grid(int leaf_grid) {
    return leaf_grid < 3 ? 1 : (5 * leaf_grid + 4) / 8;
}

/// Truth (grid × grid jittered rays each) or the thesis's 4 × 4 reference of pixel (x, y). `key`
/// names the random stream. Rays are counted in `stats`.
struct TruthParams {
    Against against = Against::kTruth;
    int grid = kTruthGrids.front();
    uint64_t key = 0;
};
TruthPair truth_pair(const RenderScene& scene, const View& view, int x, int y,
                     const TruthParams& params, CostStats& stats);

/// Unbiased estimate of the mean squared error over R, G, B after dividing by the exposure; may be
/// negative.
double squared_error(const Rgb& value, const TruthPair& truth, double exposure);
/// The same, each channel over r² + floor with r the mean of both estimates: what rel_mse is the
/// mean of. `floor` is relative_floor of the image.
double relative_squared_error(const Rgb& value, const TruthPair& truth, double exposure,
                              double floor);
/// 0.01 · mean², of the mean over pixels and channels, divided by the exposure.
double relative_floor(double mean);

/// What is known of an image's error.
struct MeasuredError {
    Estimate mse;
    std::optional<Estimate> ssim;
    std::optional<NormEstimate> irradiance;  // relative (sh_audit.h)
    std::optional<Estimate> rel_mse;
    /// Its square, expected of pixels that err independently (irradiance_noise.h).
    std::optional<Estimate> irradiance_square;
};

/// In dB; none for 0 and what is not finite.
std::optional<double> psnr_of(double mse);

/// The figures of a MeasuredError as reports show them.
struct ErrorFigures {
    double rmse = 0.0;
    Interval rmse_interval;
    std::optional<double> psnr_db;  // none where no error was found
    /// A bound is none where the error cannot be told from zero.
    std::optional<double> psnr_low_db;
    std::optional<double> psnr_high_db;
};
ErrorFigures figures_of(const Estimate& mse, double confidence);

/// The square of the largest error that meets a target of PSNR, RMSE or irradiance_rel.
double largest_square(const QualityTarget& target);

/// Whether a metric is another way to say the mean squared error.
constexpr bool is_of_squares(QualityTarget::Metric metric) {
    return metric == QualityTarget::Metric::kPsnrDb || metric == QualityTarget::Metric::kRmse;
}

/// Errors of all metrics as sizes that shrink as a render is refined: mean squared error (PSNR and
/// RMSE), rel_mse, 1 − SSIM, irradiance_square; and the largest that meets a target. None where it
/// was not measured, and of rays.
std::optional<Estimate> error_size(QualityTarget::Metric metric, const MeasuredError& error);
std::optional<double> largest_size(const QualityTarget& target);

/// Whether the estimate alone meets a target, and whether the far end of its interval does. A
/// target of rays says nothing about error: always true.
bool estimate_meets(const QualityTarget& target, const MeasuredError& error);
bool bound_meets(const QualityTarget& target, const MeasuredError& error, double confidence);

/// The same of a job's targets: all of them or any.
bool estimate_meets(const QualitySpec& quality, const MeasuredError& error);
bool bound_meets(const QualitySpec& quality, const MeasuredError& error, double confidence);

/// all_of or any_of a job's targets, as it requires.
template <class Meets>
bool targets_meet(const QualitySpec& quality, Meets meets) {
    const auto& targets = quality.targets;
    return quality.require == Require::kAll ? std::all_of(targets.begin(), targets.end(), meets)
                                            : std::any_of(targets.begin(), targets.end(), meets);
}

}  // namespace probebake
