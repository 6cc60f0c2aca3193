#include "bake/job_spec.h"

#include <algorithm>
#include <cmath>

#include "bake/job_names.h"
#include "bake/state_json.h"
#include "image/cubemap.h"

namespace probebake {
namespace {

Json write_probe(const ProbeSpec& probe) {
    Json json = {{"id", probe.id},
                 {"position_m", {probe.position_m.x, probe.position_m.y, probe.position_m.z}},
                 {"face_size_px", probe.face_size_px},
                 {"near_m", probe.near_m}};
    if (probe.far_m) json["far_m"] = *probe.far_m;
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
    return spec.quality.target.metric == QualityTarget::Metric::kIrradianceRel &&
           !spec.quality.settings;
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
    if (job.quality.target.metric == QualityTarget::Metric::kRays) {
        limit = static_cast<uint64_t>(job.quality.target.value);
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
    if (settings.kind == RendererKind::kErrorAware && std::isfinite(settings.spread)) {
        json["spread"] = settings.spread;
    }
    if (settings.kind == RendererKind::kHybrid) json["price"] = settings.price;
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
    Json& list = json["probes"]["list"] = Json::array();
    for (const ProbeSpec& probe : spec.probes) list.push_back(write_probe(probe));

    const QualitySpec& quality = spec.quality;
    const QualityTarget& target = quality.target;
    Json& out = json["quality"];
    out["targets"][std::string(name_of(target.metric))] =
        target.metric == QualityTarget::Metric::kRays ? Json(static_cast<uint64_t>(target.value))
                                                      : Json(target.value);
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
    return json;
}

}  // namespace probebake
