#include "bake/forecast.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bake/bake_probe.h"
#include "bake/learn.h"
#include "image/cubemap.h"
#include "light/lighting.h"

namespace probebake {
namespace {

using Clock = std::chrono::steady_clock;

/// Which part of a job is tried.
struct PartLimits {
    size_t one_of = 4;  // so many probes
    size_t most_probes = 4;
    int largest_face_px = 64;
};
constexpr PartLimits kOfRays;
/// What paths cost differs by a factor of hundreds between probes in and beside a cloud.
constexpr PartLimits kOfPaths{.one_of = 1, .most_probes = 16, .largest_face_px = 8};
/// As many as learn from each other, of faces that have windows of SSIM.
constexpr PartLimits kOfPathsForSsim{.one_of = 1, .most_probes = 32, .largest_face_px = 12};
/// Of a process that has baked nothing yet: code, libraries (OpenVDB the most), threads.
constexpr uint64_t kProcessBytes = uint64_t{46} << 20;
/// Steps of a ray that lights, and bytes of light per exposed face (docs/decisions.md, "Light is a
/// stage of its own").
constexpr double kStepsPerLightingRay = 12.0;
constexpr double kLightBytesPerFace = 10.0;
/// A lit state is tried in its own light where making it casts no more rays than these (some
/// seconds), else unlit.
constexpr double kLightingTriedRays = 6e6;
/// How far a range of seconds goes to both sides.
constexpr double kSecondsFactor = 2.0;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Some probes of the job in one state, with small faces, and its share of the ray budget. Without
/// atlases: they need whole grids.
JobSpec part_of(const Scene& scene, const JobSpec& job, const LightingState& state) {
    PartLimits limits = kOfRays;
    if (sees_media(scene, state)) {
        const bool ssim = has_target(job.quality, QualityTarget::Metric::kSsim);
        limits = ssim ? kOfPathsForSsim : kOfPaths;
    }
    JobSpec part = job;
    part.states = {state};
    part.probes.clear();
    part.grids.clear();
    part.products.ddgi = false;
    const size_t count =
        std::clamp<size_t>(job.probes.size() / limits.one_of, 1, limits.most_probes);
    for (size_t i = 0; i < count; ++i) {
        part.probes.push_back(job.probes[(2 * i + 1) * job.probes.size() / (2 * count)]);
        ProbeSpec& probe = part.probes.back();
        probe.face_size_px = std::min(probe.face_size_px, limits.largest_face_px);
    }
    const double share =
        static_cast<double>(pixel_count(part)) / static_cast<double>(pixel_count(job));
    if (part.budget.rays) {
        part.budget.rays =
            static_cast<uint64_t>(std::ceil(share * static_cast<double>(*part.budget.rays)));
    }
    return part;
}

/// Shadow and sky rays of lighting a state; 0 where it is not lit.
double lighting_rays(const Scene& scene, const LightingState& state, uint64_t light_bytes) {
    const double faces = static_cast<double>(light_bytes) / kLightBytesPerFace;
    double rays = state.lit() && state.sun ? 0.5 * faces * state.sun->rays : 0.0;
    if (state.lit() && state.sky) {
        const double side = std::exp2(gather_level_for(scene.voxel_size_m, state.sky->gather_m));
        rays += faces / (side * side) * state.sky->rays;
    }
    return rays;
}

}  // namespace

Forecast make_forecast(const Scene& scene, const JobSpec& job, const Plan& plan, int threads,
                       const CancelToken& cancel, const SkySource& skies) {
    Forecast forecast;
    double bytes = 0.0;
    const auto lit = static_cast<uint64_t>(
        std::count_if(job.states.begin(), job.states.end(),
                      [](const LightingState& state) { return state.lit(); }));
    const double pixels =
        static_cast<double>(pixel_count(job)) / static_cast<double>(job.states.size());
    for (const LightingState& state : job.states) {
        const double rays =
            lighting_rays(scene, state, plan.light_bytes / std::max<uint64_t>(lit, 1));
        const bool unlit = rays > kLightingTriedRays;
        const JobSpec part =
            part_of(scene, job, unlit ? LightingState(LightingState::kAlbedo) : state);
        const Clock::time_point lighting_begin = Clock::now();
        const ReadyState ready = light_state(scene, part, 0, cancel, skies);
        // A cache has this light from now on.
        const bool again = !scene.cache_dir;
        if (state.lit() && !unlit && again)
            forecast.lighting_seconds += seconds_since(lighting_begin);
        const Clock::time_point begin = Clock::now();
        Pilot pilot = run_pilot(scene, part, make_plan(scene, part), ready, cancel);
        forecast.seconds += seconds_since(begin) * static_cast<double>(pilot_pixels(job)) /
                            static_cast<double>(pilot_pixels(part));
        if (unlit) {
            const CostStats& cost = pilot.search_cost;
            forecast.lighting_seconds += rays * kStepsPerLightingRay * cost.seconds /
                                         static_cast<double>(std::max<uint64_t>(cost.steps, 1)) /
                                         threads;
        }
        std::vector<ProbeResult> results(part.probes.size());
        const Clock::time_point render_begin = Clock::now();
        const size_t teaching = probes_to_learn_from(part);
        const auto bake = [&](size_t i) {
            results[i] =
                bake_probe(scene, part, pilot, {.probe = i, .teaches = i < teaching}, cancel);
        };
        tbb::parallel_for(size_t{0}, teaching, bake);
        learn(pilot, part.quality, std::span(results).first(teaching));
        tbb::parallel_for(teaching, results.size(), bake);
        const double scale = pixels / static_cast<double>(pixel_count(part));
        forecast.seconds += scale * seconds_since(render_begin);
        for (const ProbeResult& result : results) {
            for (const ProductFile& file : result.files) {
                bytes += scale * static_cast<double>(file.size_bytes);
            }
        }
    }
    forecast.seconds += forecast.lighting_seconds;
    if (job.budget.seconds) forecast.seconds = std::min(forecast.seconds, *job.budget.seconds);
    const uint64_t units_at_once =
        std::min<uint64_t>(static_cast<uint64_t>(threads), plan.work_units);
    forecast.memory_bytes = kProcessBytes + std::max(scene.load.build.peak_bytes,
                                                     plan.scene_bytes + plan.light_bytes +
                                                         units_at_once * plan.bytes_per_unit);
    if (job.products.ddgi) bytes += static_cast<double>(plan.work_units * kDdgiBytesPerProbe);
    forecast.output_bytes = static_cast<uint64_t>(bytes);
    return forecast;
}

Json write_forecast(const Forecast& forecast) {
    return {
        {"seconds", forecast.seconds},
        {"seconds_range", {forecast.seconds / kSecondsFactor, forecast.seconds * kSecondsFactor}},
        {"lighting_seconds", forecast.lighting_seconds},
        {"memory_bytes", forecast.memory_bytes},
        {"output_bytes", forecast.output_bytes}};
}

}  // namespace probebake
