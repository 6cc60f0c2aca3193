#include "bake/quality.h"

#include <algorithm>
#include <cmath>

namespace probebake {
namespace {

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

double relative_squared_error(const Rgb& value, const TruthPair& truth, double exposure,
                              double floor) {
    double sum = 0.0;
    for (int c = 0; c < 3; ++c) {
        const double a = value[c] / exposure;
        const double r1 = truth.r1[c] / exposure;
        const double r2 = truth.r2[c] / exposure;
        const double square = (a - r1) * (a - r2);
        const double r = (r1 + r2) / 2.0;
        if (square != 0.0) sum += square / (r * r + floor);
    }
    return sum / 3.0;
}

double relative_floor(double mean) { return 0.01 * mean * mean; }

std::optional<double> psnr_of(double mse) {
    if (!(mse > 0.0) || !std::isfinite(mse)) return std::nullopt;
    return -10.0 * std::log10(mse);
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

std::optional<Estimate> error_size(QualityTarget::Metric metric, const MeasuredError& error) {
    switch (metric) {
        case QualityTarget::Metric::kPsnrDb:
        case QualityTarget::Metric::kRmse:
            return error.mse;
        case QualityTarget::Metric::kRelMse:
            return error.rel_mse;
        case QualityTarget::Metric::kSsim: {
            if (!error.ssim) return std::nullopt;
            Estimate size = *error.ssim;
            size.value = 1.0 - size.value;
            size.third_moment = -size.third_moment;
            return size;
        }
        case QualityTarget::Metric::kIrradianceRel:
            return error.irradiance_square;
        case QualityTarget::Metric::kRays:
            break;
    }
    return std::nullopt;
}

std::optional<double> largest_size(const QualityTarget& target) {
    switch (target.metric) {
        case QualityTarget::Metric::kPsnrDb:
        case QualityTarget::Metric::kRmse:
        case QualityTarget::Metric::kIrradianceRel:
            return largest_square(target);
        case QualityTarget::Metric::kRelMse:
            return target.value;
        case QualityTarget::Metric::kSsim:
            return 1.0 - target.value;
        case QualityTarget::Metric::kRays:
            break;
    }
    return std::nullopt;
}

bool estimate_meets(const QualityTarget& target, const MeasuredError& error) {
    switch (target.metric) {
        case QualityTarget::Metric::kRays:
            return true;
        case QualityTarget::Metric::kSsim:
            return error.ssim && error.ssim->value >= target.value;
        case QualityTarget::Metric::kIrradianceRel:
            return error.irradiance && error.irradiance->value() <= target.value;
        case QualityTarget::Metric::kRelMse:
            return error.rel_mse && error.rel_mse->value <= target.value;
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
        case QualityTarget::Metric::kRelMse:
            return error.rel_mse && error.rel_mse->interval(confidence).high <= target.value;
        default:
            return error.mse.interval(confidence).high <= largest_square(target);
    }
}

bool estimate_meets(const QualitySpec& quality, const MeasuredError& error) {
    return targets_meet(quality,
                        [&](const QualityTarget& target) { return estimate_meets(target, error); });
}

bool bound_meets(const QualitySpec& quality, const MeasuredError& error, double confidence) {
    return targets_meet(quality, [&](const QualityTarget& target) {
        return bound_meets(target, error, confidence);
    });
}

}  // namespace probebake
