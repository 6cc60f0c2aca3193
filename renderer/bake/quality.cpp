#include "bake/quality.h"

#include <algorithm>
#include <cmath>

namespace probebake {
namespace {

std::optional<double> psnr_of(double mse) {
    if (!(mse > 0.0) || !std::isfinite(mse)) return std::nullopt;
    return -10.0 * std::log10(mse);
}

/// What a ray anywhere in a pixel's footprint meets.
Rgb leaf_ray(const RenderScene& scene, const View& view, int x, int y, RandomStream& random,
             CostStats& stats) {
    const double u = random.uniform();
    const double v = random.uniform();
    const Ray ray = pixel_ray(view, x - 0.5 + u, y - 0.5 + v).ray;
    Hit hit = trace(scene.tree, ray, LevelOfDetail{}, scene.range);
    const Rgb color = shade(scene, ray.direction, hit);
    stats.keep(hit);
    return color;
}

}  // namespace

TruthPair truth_pair(const RenderScene& scene, const View& view, int x, int y,
                     const TruthParams& params, CostStats& stats) {
    if (params.against == Against::kReference) {
        const Rgb reference = uniform_pixel(scene, view, x, y, 4, stats).mean();
        return {reference, reference};
    }
    if (params.grid == 1) {  // too few rays for a start list to pay
        RandomStream random(params.key);
        const Rgb r1 = leaf_ray(scene, view, x, y, random, stats);
        return {r1, leaf_ray(scene, view, x, y, random, stats)};
    }
    const StartList from = start_list(scene.tree, pixel_beam(view, {x, y, x, y}, 1.0));
    stats.steps += from.steps;
    RandomStream random(params.key);
    const Rgb r1 = stratified_pixel(scene, view, x, y, params.grid, from, random, stats);
    const Rgb r2 = stratified_pixel(scene, view, x, y, params.grid, from, random, stats);
    return {r1, r2};
}

double squared_error(const Rgb& value, const TruthPair& truth, double exposure) {
    const Vec3 d1 = (Vec3(value) - Vec3(truth.r1)) / exposure;
    const Vec3 d2 = (Vec3(value) - Vec3(truth.r2)) / exposure;
    return glm::dot(d1, d2) / 3.0;
}

ErrorFigures figures_of(const Estimate& mse, double confidence) {
    const Interval interval = mse.interval(confidence);
    const auto root = [](double x) { return std::sqrt(std::max(0.0, x)); };
    return {.rmse = root(mse.value),
            .rmse_interval = {root(interval.low), root(interval.high)},
            .psnr_db = psnr_of(mse.value),
            .psnr_low_db = psnr_of(interval.high),
            .psnr_high_db = psnr_of(interval.low)};
}

double largest_square(const QualityTarget& target) {
    return target.metric == QualityTarget::Metric::kPsnrDb ? std::pow(10.0, -target.value / 10.0)
                                                           : target.value * target.value;
}

bool estimate_meets(const QualityTarget& target, const MeasuredError& error) {
    switch (target.metric) {
        case QualityTarget::Metric::kRays:
            return true;
        case QualityTarget::Metric::kSsim:
            return error.ssim && error.ssim->value >= target.value;
        case QualityTarget::Metric::kIrradianceRel:
            return error.irradiance && error.irradiance->value() <= target.value;
        default:
            return error.mse.value <= largest_square(target);
    }
}

bool bound_meets(const QualityTarget& target, const MeasuredError& error, double confidence) {
    switch (target.metric) {
        case QualityTarget::Metric::kRays:
            return true;
        case QualityTarget::Metric::kSsim:
            return error.ssim && error.ssim->interval(confidence).low >= target.value;
        case QualityTarget::Metric::kIrradianceRel:
            return error.irradiance && error.irradiance->interval(confidence).high <= target.value;
        default:
            return error.mse.interval(confidence).high <= largest_square(target);
    }
}

bool surely_misses(const QualityTarget& target, const MeasuredError& error, double confidence) {
    switch (target.metric) {
        case QualityTarget::Metric::kRays:
            return false;
        case QualityTarget::Metric::kSsim:
            return error.ssim && error.ssim->interval(confidence).high < target.value;
        case QualityTarget::Metric::kIrradianceRel:
            return error.irradiance && error.irradiance->interval(confidence).low > target.value;
        default:
            return error.mse.interval(confidence).low > largest_square(target);
    }
}

}  // namespace probebake
