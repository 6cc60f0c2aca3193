#include "bake/media_state.h"

#include <algorithm>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "bake/probe_view.h"
#include "scene/media_file.h"

namespace probebake {
namespace {

/// Where media have no end, first rays have one: where the request's own far_m ends.
constexpr double kEndless_m = 1e9;

[[noreturn]] void refuse(const std::string& pointer, const std::string& why) {
    throw SpecError(SpecError::Kind::kUnacceptable, pointer, why);
}

ChoiceParams choice_params(const JobSpec& job) {
    ChoiceParams params;
    params.forced = job.quality.tracker;
    return params;
}

std::string describe(const Medium& medium) {
    std::ostringstream text;
    text << medium.spec.name << ": ";
    if (const auto* grid = std::get_if<GridShape>(&medium.spec.shape)) {
        const IVec3& cells = grid->density->cells();
        text << "a grid of " << cells.x << " × " << cells.y << " × " << cells.z
             << " cells, octree of " << medium.octree.leaf_count() << " leaves and depth "
             << medium.octree.depth_reached();
    } else {
        text << (std::holds_alternative<FogShape>(medium.spec.shape) ? "fog" : "homogeneous");
    }
    return text.str();
}

Lighting lighting_of(const ReadyState& state) {
    Lighting lighting;
    if (state.spec.sun) lighting.sun = state.spec.sun->sun;
    if (state.light != nullptr) lighting.sky = state.light->sky;
    lighting.emission = state.spec.emission;
    return lighting;
}

bool has_grid(const Media& media) {
    return std::any_of(media.all().begin(), media.all().end(),
                       [](const Medium& medium) { return medium.is_grid(); });
}

/// Whether light of emissive voxels may be scattered in a state of the job.
bool meets_emitters(const Scene& scene, const JobSpec& job) {
    return scene.emits() && facts_of(scene.media).scatters &&
           std::any_of(job.states.begin(), job.states.end(), [&](const LightingState& state) {
               return sees_media(scene, state) && state.emission;
           });
}

std::vector<MediumSpec> specs_of(const Media& media) {
    std::vector<MediumSpec> specs;
    for (const Medium& medium : media.all()) specs.push_back(medium.spec);
    return specs;
}

}  // namespace

bool sees_media(const Scene& scene, const LightingState& state) {
    return !scene.media.empty() && state.kind != LightingState::Kind::kAlbedo;
}

MediaPlan plan_media(const Scene& scene, const JobSpec& job) {
    const QualitySpec& quality = job.quality;
    if (quality.against == Against::kReference) {
        refuse("/quality/against", "paths through media are measured against the truth only");
    }
    const bool all =
        std::all_of(job.states.begin(), job.states.end(),
                    [&](const LightingState& state) { return sees_media(scene, state); });
    if (all && quality.renderer) {
        refuse("/quality/renderer",
               "every state of this job is seen through media, by paths: "
               "expected \"auto\"; quality.tracker chooses how they fly");
    }
    for (size_t i = 0; i < job.states.size(); ++i) {
        if (job.states[i].radiance_per == RadiancePer::kVoxel) {
            refuse("/lighting_states/" + std::to_string(i) + "/radiance_per",
                   "paths through media light every face by itself: expected \"face\"");
        }
    }
    for (const ProbeSpec& probe : job.probes) {
        const uint64_t pixels = owned_pixel_count(probe.face_size_px);
        if (ray_limit(job, probe).value_or(2 * pixels) < 2 * pixels) {
            const bool target = only_target(quality, QualityTarget::Metric::kRays);
            refuse(target ? "/quality/targets/rays" : "/budget/rays",
                   "through media a pixel takes at least two paths");
        }
    }
    MediaPlan plan;
    try {
        plan.choice = choose_tracker(facts_of(scene.media), choice_params(job));
    } catch (const std::invalid_argument& error) {
        refuse("/quality/tracker", error.what());
    }
    for (const Medium& medium : scene.media.all()) plan.media.push_back(describe(medium));
    if (meets_emitters(scene, job)) {
        plan.emitters =
            "by scattering, and by rays to them where a pilot finds variance × cost smaller so";
    } else {
        plan.choice.left_out.emplace_back("rays to emissive voxels: " +
                                          std::string(!scene.emits() ? "no voxel emits"
                                                      : !facts_of(scene.media).scatters
                                                          ? "no medium scatters"
                                                          : "no lighting state shows emission"));
    }
    plan.bytes = scene.media.memory_bytes();
    return plan;
}

MediaState::MediaState(const Scene& scene, const ReadyState& state, const JobSpec& job,
                       const PilotRay& ray)
    : lighting(lighting_of(state)) {
    const auto with = [&](const Media& which) {
        return ScatterScene{.tree = scene.tree,
                            .voxel_size_m = scene.voxel_size_m,
                            .corner_m = scene.corner_m,
                            .media = which,
                            .lighting = lighting,
                            .shadow = state.spec.shadows,
                            .emitters = emitters ? &*emitters : nullptr};
    };
    PilotParams params;
    params.choice = choice_params(job);
    params.key = random_key(
        {job.seed, static_cast<uint64_t>(StreamPurpose::kMediaPilot), stream_of(state.spec)});
    if (has_grid(scene.media)) {
        const MajorantParams octree;
        depth =
            choose_depth(with(scene.media), specs_of(scene.media), octree.threshold, ray, params);
        if (depth.max_depth != octree.max_depth) {
            own_media = Media(specs_of(scene.media), {.max_depth = depth.max_depth});
        }
    }
    if (lighting.emission && scene.emits() && facts_of(scene.media).scatters) {
        emitters.emplace(scene.tree);
        if (emitters->empty()) emitters.reset();
    }
    const ScatterScene flown = with(media(scene));
    tracker_pilot = choose_by_pilot(flown, ray, params);
    if (emitters) {
        emitter_pilot = choose_emitters(flown, tracker_pilot.choice, ray, params);
        if (!emitter_pilot->sampled) emitters.reset();
    }
    tracer.emplace(with(media(scene)), tracker_pilot.choice);
}

double effective_far_through_media_m(const Scene& scene, const ProbeSpec& probe) {
    if (probe.far_m) return *probe.far_m;
    const Box extent = extent_of(scene.media);
    if (!is_finite(extent.low) || !is_finite(extent.high)) return kEndless_m;
    const Vec3 p = probe.position_m;
    const Vec3 farthest = glm::max(glm::abs(extent.low - p), glm::abs(extent.high - p));
    return std::max(scene.reach_m(p), glm::length(farthest));
}

VolumeView volume_view(const Scene& scene, const ProbeSpec& probe, uint64_t key) {
    return {.origin_m = probe.position_m,
            .face_size_px = probe.face_size_px,
            .range = {probe.near_m, effective_far_through_media_m(scene, probe)},
            .key = key};
}

CostStats cost_of(const PathCount& count) {
    CostStats cost;
    cost.rays = count.paths;
    cost.missed_rays = count.misses;
    cost.steps = count.steps;
    cost.media = {.lookups = count.lookups(),
                  .leaves = count.flights.leaves + count.shadows.leaves,
                  .collisions = count.flights.collisions,
                  .null_collisions = count.flights.null_collisions,
                  .scatterings = count.scatterings,
                  .shadow_rays = count.shadow_rays,
                  .faults = count.all_faults()};
    return cost;
}

CubemapRender render_through_media(const Scene& scene, const PathTracer& tracer,
                                   const VolumeView& view, const RenderSettings& settings,
                                   const PathLimits& limits, const CancelToken& cancel) {
    VolumeQuality quality{.target_rmse = settings.noise,
                          .first_samples = settings.samples,
                          .most_samples = kMostPathsPerPixel,
                          .most_paths = limits.paths,
                          .most_seconds = limits.seconds};
    if (limits.paths) {
        const uint64_t per_pixel = *limits.paths / owned_pixel_count(view.face_size_px);
        quality.first_samples = static_cast<int>(std::min(
            static_cast<uint64_t>(quality.first_samples), std::max<uint64_t>(2, per_pixel)));
    }
    VolumeCubemap cube = render_volume_cubemap(tracer, view, quality, cancel);
    CubemapRender out{.color = std::move(cube.color), .limited = cube.limited};
    out.aux.reserve(cube.pixels.size());
    const double metre = 1.0 / scene.voxel_size_m;
    for (const VolumePixel& pixel : cube.pixels) {
        const Vec3 error(pixel.standard_error);
        out.aux.push_back(
            {.distance = static_cast<float>(pixel.distance_m * metre),
             .squared_distance = static_cast<float>(pixel.squared_distance_m2 * metre * metre),
             .standard_error = pixel.standard_error,
             .samples = static_cast<float>(pixel.samples),
             .predicted_error = static_cast<float>(glm::dot(error, error) / 3.0)});
    }
    for (const CubeFace face : kCubeFaces) {
        const auto f = static_cast<size_t>(index_of(face));
        out.faces[f] = cost_of(cube.faces[f]);
        out.faces[f].seconds = cube.seconds[f];
        out.pixels[f] = owned_pixel_count(face, view.face_size_px);
    }
    return out;
}

TruthPair path_truth(const PathTracer& tracer, const VolumeView& view, const CubePixel& owner,
                     int paths, uint64_t key, CostStats& stats) {
    PathCount count;
    const auto mean = [&](uint64_t which) {
        const uint64_t own = random_key({key, which});
        Vec3 sum(0.0);
        for (int i = 0; i < paths; ++i) {
            sum += pixel_path(tracer, view, owner, {own, static_cast<uint32_t>(i)}, count).radiance;
        }
        return Rgb(sum / static_cast<double>(paths));
    };
    const TruthPair truth{mean(1), mean(2)};
    stats += cost_of(count);
    return truth;
}

}  // namespace probebake
