// The terrains under four positions of the sun (thesis, 5.3): sun and self-shadowing alone, as its
// data have it, so that shadows are black. Error-aware rays do not depend on light; the adaptive
// renderer is shown with the settings it has in albedo, as in the thesis, and at equal steps. The
// cost is that of the thesis, kThesisBudget.
#include <cmath>
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

Json run_times_of_day(const ExperimentInput& input) {
    const Scene& scene = input.work.scene();
    const RecordSet& albedo = input.work.nadir();
    const auto budget =
        static_cast<uint64_t>(kThesisBudget * static_cast<double>(albedo.count(lod_outcome).steps));
    const double threshold = albedo.threshold_for_steps(budget, kThesisDecay);
    const auto error_aware = [threshold](const PixelRecord& pixel) {
        return error_aware_outcome(pixel, threshold, kThesisDecay);
    };
    const double albedo_normaliser =
        albedo.normaliser_for_steps(albedo.count(error_aware).steps, MissesInKernel::kLeftOut);
    const CancelToken cancel;
    Json rows = Json::array();
    for (size_t t = 0; t < kTimes.size(); ++t) {
        const LitScene lit = light_scene(scene.tree, sun_at(kTimes[t]), {.sun_rays = 1}, cancel);
        RenderScene render = albedo_of(scene);
        render.lit = &lit.colors;
        const RecordSet set(render, study_view(scene, input.work.size()));
        const Measured measured = set.measure(error_aware);
        Json row = {{"time", t},
                    {"elevation_deg", kTimes[t].elevation_deg},
                    {"azimuth_deg", kTimes[t].azimuth_deg},
                    {"luminance", mean_luminance(set.truth()[0])},
                    {"error_aware", write_measured(measured)}};
        const auto add = [&](const char* name, double normaliser, MissesInKernel misses) {
            row[name] = write_measured(set.measure([&](const PixelRecord& pixel) {
                return adaptive_outcome(pixel, normaliser, misses);
            }));
        };
        add("adaptive_of_albedo", albedo_normaliser, MissesInKernel::kLeftOut);
        for (const MissesInKernel misses : {MissesInKernel::kLeftOut, MissesInKernel::kBlack}) {
            add(misses == MissesInKernel::kLeftOut ? "adaptive" : "adaptive_black",
                set.normaliser_for_steps(measured.counts.steps, misses), misses);
        }
        rows.push_back(std::move(row));
    }
    return {{"rows", std::move(rows)}};
}

}  // namespace probebake::study
