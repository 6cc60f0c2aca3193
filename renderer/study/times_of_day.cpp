// The terrains under four positions of the sun (thesis, 5.3): sun and self-shadowing alone, as its
// data have it, so that shadows are black. Error-aware rays do not depend on light; the adaptive
// renderer is shown with the settings it has in albedo, as in the thesis, and at equal steps. The
// cost is that of the thesis, kThesisBudget.
#include <cmath>
#include <limits>
#include <numbers>

#include "error/node_error.h"
#include "light/lighting.h"
#include "study/experiments.h"

namespace probebake::study {
namespace {

struct TimeOfDay {
    double elevation_deg;
    double azimuth_deg;  // from +X towards +Z
};
constexpr std::array<TimeOfDay, 4> kTimes = {
    {{50.0, 120.0}, {15.0, 75.0}, {60.0, 200.0}, {30.0, 285.0}}};

Lighting sun_at(const TimeOfDay& time) {
    const double radians = std::numbers::pi / 180.0;
    const double up = std::sin(time.elevation_deg * radians);
    const double along = std::cos(time.elevation_deg * radians);
    const Vec3 direction(along * std::cos(time.azimuth_deg * radians), up,
                         along * std::sin(time.azimuth_deg * radians));
    // A surface that faces the sun has its albedo as radiance.
    return {.sun = Sun{.direction = direction, .irradiance = Rgb(std::numbers::pi_v<float>)},
            .emission = false};
}

double mean_luminance(const Image& image) {
    double sum = 0.0;
    for (const Rgb& pixel : image.pixels()) sum += static_cast<double>(luminance(pixel));
    return sum / static_cast<double>(image.pixels().size());
}

}  // namespace

Json times_of_day_params() {
    Json params = {kThesisBudget};
    for (const TimeOfDay& time : kTimes) {
        params.push_back({time.elevation_deg, time.azimuth_deg});
    }
    return params;
}

namespace {

/// What the other rows take over from albedo.
Json albedo_settings(const RecordSet& albedo) {
    const auto budget =
        static_cast<uint64_t>(kThesisBudget * static_cast<double>(albedo.count(lod_outcome).steps));
    const double threshold = albedo.threshold_for_steps(budget, kThesisDecay);
    const uint64_t steps = albedo
                               .count([threshold](const PixelRecord& pixel) {
                                   return error_aware_outcome(pixel, threshold, kThesisDecay);
                               })
                               .steps;
    const double normaliser = albedo.normaliser_for_steps(steps, MissesInKernel::kLeftOut);
    return {{"threshold", threshold},
            {"normaliser", std::isfinite(normaliser) ? Json(normaliser) : Json()}};
}

Json run_time(const ExperimentInput& input, size_t t, const Json& albedo) {
    const Scene& scene = input.work.scene();
    const LitScene lit = light_scene(scene.tree, sun_at(kTimes[t]), {.sun_rays = 1}, CancelToken());
    RenderScene render = albedo_of(scene);
    render.lit = &lit.colors;
    const RecordSet set(render, study_view(scene, input.work.size()));
    const double threshold = albedo["threshold"].get<double>();
    const Measured measured = set.measure([threshold](const PixelRecord& pixel) {
        return error_aware_outcome(pixel, threshold, kThesisDecay);
    });
    Json row = {{"time", t},
                {"elevation_deg", kTimes[t].elevation_deg},
                {"azimuth_deg", kTimes[t].azimuth_deg},
                {"luminance", mean_luminance(set.truth()[0])},
                {"error_aware", write_measured(measured)}};
    const auto add = [&](const char* name, double normaliser, MissesInKernel misses) {
        row[name] = write_measured(set.measure(
            [&](const PixelRecord& pixel) { return adaptive_outcome(pixel, normaliser, misses); }));
    };
    // JSON has no infinity.
    const Json& normaliser = albedo["normaliser"];
    add("adaptive_of_albedo",
        normaliser.is_number() ? normaliser.get<double>() : std::numeric_limits<double>::infinity(),
        MissesInKernel::kLeftOut);
    for (const MissesInKernel misses : {MissesInKernel::kLeftOut, MissesInKernel::kBlack}) {
        add(misses == MissesInKernel::kLeftOut ? "adaptive" : "adaptive_black",
            set.normaliser_for_steps(measured.counts.steps, misses), misses);
    }
    return row;
}

}  // namespace

Json run_times_of_day(const ExperimentInput& input) {
    const Json albedo = input.part("albedo", [&] { return albedo_settings(input.work.nadir()); });
    Json rows = Json::array();
    for (size_t t = 0; t < kTimes.size(); ++t) {
        rows.push_back(input.part(std::to_string(t), [&] { return run_time(input, t, albedo); }));
    }
    return {{"rows", std::move(rows)}};
}

}  // namespace probebake::study
