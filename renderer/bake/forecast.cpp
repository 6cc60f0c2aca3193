#include "bake/forecast.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

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
/// Paths that are tried in a state at most (some seconds): what more of them a target takes is told
/// by the error that these leave.
constexpr double kMostTriedPaths = 3e6;
/// How far a range of seconds goes to both sides, and where more paths are needed than are tried.
constexpr double kSecondsFactor = 2.0;
constexpr double kExtrapolatedFactor = 4.0;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Some probes of a job.
struct Part {
    JobSpec job;
    /// Of the paths that it may take, how many times as many the job leaves it; 1: it is not held
    /// back.
    double held_back = 1.0;
};

/// Of the rays of the job, budget or target, the part gets its share, and no more paths than are
/// tried at most.
void share_rays(Part& part, const JobSpec& job, double share, double share_of_cubemap,
                bool through_media) {
    QualityTarget& target = part.job.quality.targets.front();
    const auto least = static_cast<double>(2 * pixel_count(part.job));
    double allowed = std::numeric_limits<double>::infinity();
    if (job.budget.rays) allowed = std::ceil(share * static_cast<double>(*job.budget.rays));
    if (only_target(job.quality, QualityTarget::Metric::kRays)) {
        target.value = std::max(std::ceil(share_of_cubemap * target.value), 1.0);
        const double probes = static_cast<double>(part.job.probes.size());
        allowed = std::min(allowed, target.value * probes);
    }
    const double most = std::max(kMostTriedPaths, least);
    if (through_media && allowed > most) {
        part.held_back = allowed / most;
        allowed = most;
        part.job.quality.evidence.audit = true;  // the error tells what is missing
    }
    if (std::isfinite(allowed)) part.job.budget.rays = static_cast<uint64_t>(allowed);
}

/// In one state, with small faces. Without atlases: they need whole grids.
Part part_of(const Scene& scene, const JobSpec& job, const LightingState& state) {
    const bool through_media = sees_media(scene, state);
    PartLimits limits = kOfRays;
    if (through_media) {
        const bool ssim = has_target(job.quality, QualityTarget::Metric::kSsim);
        limits = ssim ? kOfPathsForSsim : kOfPaths;
    }
    Part part{.job = job};
    part.job.states = {state};
    part.job.probes.clear();
    part.job.grids.clear();
    part.job.products.ddgi = false;
    const size_t count =
        std::clamp<size_t>(job.probes.size() / limits.one_of, 1, limits.most_probes);
    for (size_t i = 0; i < count; ++i) {
        part.job.probes.push_back(job.probes[(2 * i + 1) * job.probes.size() / (2 * count)]);
    }
    const auto whole_faces = static_cast<double>(pixel_count(part.job));
    for (ProbeSpec& probe : part.job.probes) {
        probe.face_size_px = std::min(probe.face_size_px, limits.largest_face_px);
    }
    const auto pixels = static_cast<double>(pixel_count(part.job));
    share_rays(part, job, pixels / static_cast<double>(pixel_count(job)), pixels / whole_faces,
               through_media);
    return part;
}

/// How many times the paths of a probe its targets take: errors of paths fall with their number.
double missing_paths(const QualitySpec& quality, const ProbeResult& result) {
    std::optional<double> missing;
    for (const QualityTarget& target : quality.targets) {
        const auto error = error_size(target.metric, result.certificate.error);
        const auto allowed = largest_size(target);
        if (!error || !allowed) continue;
        double its = error->value / *allowed;
        if (target.metric == QualityTarget::Metric::kSsim) {  // saturates
            const auto variance = [](double lost) { return lost / std::max(1e-3, 1.0 - lost); };
            its = variance(error->value) / variance(*allowed);
        }
        const bool all = quality.require == Require::kAll;
        missing = !missing ? its : (all ? std::max(*missing, its) : std::min(*missing, its));
    }
    return missing.value_or(1.0);
}

/// What the paths that were held back would add to the seconds, as a factor.
double extrapolated(const Part& part, std::span<const ProbeResult> results) {
    double tried = 0.0;
    double wanted = 0.0;
    for (const ProbeResult& result : results) {
        const bool of_rays = only_target(part.job.quality, QualityTarget::Metric::kRays);
        const double missing = of_rays ? part.held_back : missing_paths(part.job.quality, result);
        tried += result.wall_seconds;
        wanted += result.wall_seconds * std::clamp(missing, 1.0, part.held_back);
    }
    return tried > 0.0 ? wanted / tried : 1.0;
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
        const Part part_with_limit =
            part_of(scene, job, unlit ? LightingState(LightingState::kAlbedo) : state);
        const JobSpec& part = part_with_limit.job;
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
        const double more = extrapolated(part_with_limit, results);
        forecast.extrapolated = forecast.extrapolated || more > 1.5;
        forecast.seconds += scale * more * seconds_since(render_begin);
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
    const double factor = forecast.extrapolated ? kExtrapolatedFactor : kSecondsFactor;
    return {{"seconds", forecast.seconds},
            {"seconds_range", {forecast.seconds / factor, forecast.seconds * factor}},
            {"lighting_seconds", forecast.lighting_seconds},
            {"memory_bytes", forecast.memory_bytes},
            {"output_bytes", forecast.output_bytes}};
}

}  // namespace probebake
