#include "bake/job_spec.h"

#include <algorithm>
#include <cmath>

#include "bake/job_names.h"
#include "bake/state_json.h"
#include "image/cubemap.h"

namespace probebake {
namespace {

Json write_vector(const Vec3& v) { return {v.x, v.y, v.z}; }

void write_view(const ProbeSpec& probe, Json& json) {
    json["face_size_px"] = probe.face_size_px;
    json["near_m"] = probe.near_m;
    if (probe.far_m) json["far_m"] = *probe.far_m;
}

/// A grid stays a grid, however many probes it has.
Json write_probes(const JobSpec& spec) {
    Json json = {{"list", Json::array()}, {"grids", Json::array()}};
    const size_t listed = spec.grids.empty() ? spec.probes.size() : spec.grids[0].first_probe;
    for (size_t p = 0; p < listed; ++p) {
        const ProbeSpec& probe = spec.probes[p];
        Json item = {{"id", probe.id},
                     {"position_m",
                      write_vector(probe.place ? probe.place->requested_m : probe.position_m)}};
        write_view(probe, item);
        json["list"].push_back(std::move(item));
    }
    for (const ProbeGrid& grid : spec.grids) {
        Json item = {{"id", grid.id},
                     {"origin_m", write_vector(grid.origin_m)},
                     {"spacing_m", write_vector(grid.spacing_m)},
                     {"counts", {grid.counts.x, grid.counts.y, grid.counts.z}}};
        write_view(spec.probes[grid.first_probe], item);
        json["grids"].push_back(std::move(item));
    }
    return json;
}

Json write_products(const Products& products) {
    Json names = Json::array();
    for (size_t i = 0; i < kProductNames.size(); ++i) {
        if (products.*kProductFlags[i]) names.push_back(kProductNames[i]);
    }
    return names;
}

}  // namespace

bool wants_leaf_rays_only(const JobSpec& spec) {
    return only_target(spec.quality, QualityTarget::Metric::kIrradianceRel) &&
           !spec.quality.settings;
}

bool has_target(const QualitySpec& quality, QualityTarget::Metric metric) {
    return std::any_of(quality.targets.begin(), quality.targets.end(),
                       [&](const QualityTarget& target) { return target.metric == metric; });
}

bool only_target(const QualitySpec& quality, QualityTarget::Metric metric) {
    return quality.targets.size() == 1 && quality.targets.front().metric == metric;
}

const ProbeGrid* grid_of(const JobSpec& spec, size_t probe) {
    for (const ProbeGrid& grid : spec.grids) {
        if (probe >= grid.first_probe && probe - grid.first_probe < grid.size()) return &grid;
    }
    return nullptr;
}

std::string_view name_of(QualityTarget::Metric metric) {
    return kMetricNames[static_cast<size_t>(metric)];
}
std::string_view name_of(Against against) { return kAgainstNames[static_cast<size_t>(against)]; }

uint64_t texel_count(const JobSpec& spec) {
    uint64_t texels = 0;
    for (const ProbeSpec& probe : spec.probes) {
        const auto n = static_cast<uint64_t>(probe.face_size_px);
        texels += 6 * n * n * spec.states.size();
    }
    return texels;
}

uint64_t pixel_count(const JobSpec& spec) {
    uint64_t pixels = 0;
    for (const ProbeSpec& probe : spec.probes) {
        pixels += owned_pixel_count(probe.face_size_px) * spec.states.size();
    }
    return pixels;
}

std::optional<uint64_t> ray_limit(const JobSpec& job, const ProbeSpec& probe) {
    std::optional<uint64_t> limit;
    if (only_target(job.quality, QualityTarget::Metric::kRays)) {
        limit = static_cast<uint64_t>(job.quality.targets.front().value);
    }
    if (job.budget.rays) {
        const auto share =
            static_cast<uint64_t>(static_cast<unsigned __int128>(*job.budget.rays) *
                                  owned_pixel_count(probe.face_size_px) / pixel_count(job));
        limit = std::min(limit.value_or(share), share);
    }
    return limit;
}

Json write_settings(const RenderSettings& settings) {
    Json json = {{"renderer", name_of(settings.kind)}};
    if (settings.kind == RendererKind::kErrorAware) {
        json["threshold"] = settings.threshold;
        json["decay"] = settings.decay;
    }
    if (settings.kind == RendererKind::kErrorAware || settings.kind == RendererKind::kReference ||
        settings.kind == RendererKind::kHybrid) {
        json["leaf_grid"] = settings.leaf_grid;
    }
    if (settings.shifted_grid) json["shifted_grid"] = true;
    if (settings.kind == RendererKind::kErrorAware && std::isfinite(settings.spread)) {
        json["spread"] = settings.spread;
    }
    if (settings.kind == RendererKind::kHybrid) {
        json["price"] = settings.price;
        if (settings.least_grid > 1) json["least_grid"] = settings.least_grid;
    }
    if (settings.kind == RendererKind::kPaths) {
        json["samples"] = settings.samples;
        json["noise"] = settings.noise;
    }
    if (settings.kind == RendererKind::kAdaptive) {
        json["normaliser"] = settings.normaliser;
        json["misses_in_kernel"] = kMissesNames[static_cast<size_t>(settings.misses_in_kernel)];
    }
    if (settings.fixed_level) json["fixed_level"] = *settings.fixed_level;
    return json;
}

Json write_job(const JobSpec& spec) {
    Json json = {{"scene", spec.scene}, {"seed", spec.seed}};
    for (const LightingState& state : spec.states) {
        json["lighting_states"].push_back(write_state_spec(state));
    }
    json["products"] = write_products(spec.products);
    json["probes"] = write_probes(spec);

    if (spec.validity) {
        json["validity"] = {{"max_backface", spec.validity->rules.max_backface},
                            {"max_closed_in", spec.validity->rules.max_closed_in},
                            {"relocate", spec.validity->relocate},
                            {"max_offset_m", spec.validity->max_offset_m}};
    }

    const QualitySpec& quality = spec.quality;
    Json& out = json["quality"];
    for (const QualityTarget& target : quality.targets) {
        out["targets"][std::string(name_of(target.metric))] =
            target.metric == QualityTarget::Metric::kRays
                ? Json(static_cast<uint64_t>(target.value))
                : Json(target.value);
    }
    out["require"] = kRequireNames[static_cast<size_t>(quality.require)];
    out["renderer"] = quality.renderer ? name_of(*quality.renderer) : "auto";
    if (quality.tracker) out["tracker"] = name_of(*quality.tracker);
    out["against"] = name_of(quality.against);
    out["weighting"] = kWeightingNames[static_cast<size_t>(quality.weighting)];
    if (quality.exposure) out["exposure"] = *quality.exposure;
    if (quality.settings) {
        out["settings"] = write_settings(*quality.settings);
        out["settings"].erase("renderer");
    }
    out["evidence"] = {{"audit", quality.evidence.audit},
                       {"confidence", quality.evidence.confidence}};
    if (quality.evidence.pixels_per_probe) {
        out["evidence"]["pixels_per_probe"] = *quality.evidence.pixels_per_probe;
    }
    json["budget"] = Json::object();
    if (spec.budget.rays) json["budget"]["rays"] = *spec.budget.rays;
    if (spec.budget.seconds) json["budget"]["seconds"] = *spec.budget.seconds;
    if (spec.budget.memory_bytes) json["budget"]["memory_bytes"] = *spec.budget.memory_bytes;
    json["on_budget_exhausted"] =
        kOnBudgetExhaustedNames[static_cast<size_t>(spec.on_budget_exhausted)];
    json["priority"] = spec.priority;
    return json;
}

}  // namespace probebake
