#include "bake/leaf_ray_pilot.h"

#include <algorithm>
#include <cmath>

#include "bake/audit_size.h"

namespace probebake {
namespace {

/// Points of the curve after the first.
constexpr size_t kFinerPoints = 4;

}  // namespace

void begin_with_one_ray(Pilot& pilot) {
    constexpr std::array kFiner = {2, 3, 4, 8, 16};
    const auto shifted = [](int grid) {
        return RenderSettings{
            .kind = RendererKind::kReference, .leaf_grid = grid, .shifted_grid = true};
    };
    pilot.settings = shifted(1);
    pilot.settings_mse = 1.0;
    for (const int grid : kFiner) {
        pilot.finer.push_back({shifted(grid), 1.0 / (grid * grid * grid)});
    }
}

std::vector<RenderSettings> leaf_ray_curve(const Pilot& pilot) {
    std::vector<RenderSettings> settings{pilot.settings};
    for (size_t i = 0; i < kFinerPoints; ++i) settings.push_back(pilot.finer[i].settings);
    return settings;
}

void learn_from_leaf_ray_curve(Pilot& pilot, const JobSpec& job) {
    const auto pooled = [&](const ProbeSpec& probe) {
        return irradiance_is_pooled(job, probe.face_size_px);
    };
    if (std::none_of(job.probes.begin(), job.probes.end(), pooled)) return;
    const Estimate& finest = pilot.curve.back().error.mse;
    if (!tells(finest)) return;
    for (const CurvePoint& point : pilot.curve) {
        const int grid = point.settings.leaf_grid;
        if (point.settings == pilot.settings) pilot.settings_mse = point.error.mse.value;
        for (FinerSettings& finer : pilot.finer) {
            const double rays = std::pow(finer.settings.leaf_grid / static_cast<double>(grid), 2.0);
            if (rays >= 1.0) finer.mse = point.error.mse.value / rays;
        }
    }
    const double known_to = finest.standard_error() / finest.value;
    ErrorPrior prior = kUsualIrradiancePrior;
    prior.spread = std::hypot(prior.spread, known_to);
    prior.common = known_to;
    pilot.steering = {steering_of(job.quality.targets.front(), prior)};
}

}  // namespace probebake
