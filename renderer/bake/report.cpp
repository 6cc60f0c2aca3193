#include "bake/report.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "bake/job_names.h"
#include "bake/state_error.h"

namespace probebake {
namespace {

template <class T>
Json optional_json(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json write_cost(const CostStats& cost) {
    Json json = {{"rays", cost.rays},       {"discarded_rays", cost.discarded_rays},
                 {"hit_rays", cost.hits()}, {"missed_rays", cost.missed_rays},
                 {"steps", cost.steps},     {"box_tests", cost.box_tests},
                 {"seconds", cost.seconds}};
    if (cost.media != MediaCost{}) {
        json["media"] = {{"samples", cost.rays},
                         {"lookups", cost.media.lookups},
                         {"leaves", cost.media.leaves},
                         {"collisions", cost.media.collisions},
                         {"null_collisions", cost.media.null_collisions},
                         {"scatterings", cost.media.scatterings},
                         {"shadow_rays", cost.media.shadow_rays},
                         {"faults", cost.media.faults}};
    }
    return json;
}

/// With the levels at which rays stopped, up to the highest one.
Json write_cost_with_levels(const CostStats& cost) {
    Json json = write_cost(cost);
    size_t levels = cost.level_histogram.size();
    while (levels > 0 && cost.level_histogram[levels - 1] == 0) --levels;
    json["level_histogram"] = Json::array();
    for (size_t i = 0; i < levels; ++i) json["level_histogram"].push_back(cost.level_histogram[i]);
    return json;
}

Json write_error(const MeasuredError& error, double confidence) {
    const ErrorFigures figures = figures_of(error.mse, confidence);
    Json json = {{"rmse", figures.rmse},
                 {"rmse_interval", {figures.rmse_interval.low, figures.rmse_interval.high}},
                 {"psnr_db", optional_json(figures.psnr_db)},
                 {"psnr_db_interval",
                  {optional_json(figures.psnr_low_db), optional_json(figures.psnr_high_db)}},
                 {"exact", error.mse.nothing_found()},
                 {"samples", error.mse.samples}};
    if (error.mse.nothing_found()) {
        json["share_of_wrong_pixels_at_most"] = unseen_share(error.mse.samples, confidence);
    }
    if (error.irradiance) {
        const Interval interval = error.irradiance->interval(confidence);
        json["irradiance_rel"] = error.irradiance->value();
        json["irradiance_rel_interval"] = {interval.low, interval.high};
    } else if (error.irradiance_square) {
        const ErrorFigures expected = figures_of(*error.irradiance_square, confidence);
        json["irradiance_rel"] = expected.rmse;
        json["irradiance_rel_interval"] = {expected.rmse_interval.low, expected.rmse_interval.high};
    }
    if (error.rel_mse) {
        const Interval interval = error.rel_mse->interval(confidence);
        json["rel_mse"] = error.rel_mse->value;
        json["rel_mse_interval"] = {interval.low, interval.high};
    }
    if (error.ssim) {
        const Interval interval = error.ssim->interval(confidence);
        json["ssim"] = error.ssim->value;
        json["ssim_interval"] = {interval.low, interval.high};
    }
    return json;
}

/// As the kernel names it; empty where it does not.
std::string cpu_model() {
    std::ifstream info("/proc/cpuinfo");
    constexpr std::string_view kKey = "model name";
    for (std::string line; std::getline(info, line);) {
        const size_t colon = line.find(": ");
        if (line.starts_with(kKey) && colon != std::string::npos) return line.substr(colon + 2);
    }
    return {};
}

/// In the place of an audit's figures of a target's metric those of a posterior.
void tell(Json& json, QualityTarget::Metric metric, const PooledError& error) {
    const Interval& interval = error.interval;
    switch (metric) {
        case QualityTarget::Metric::kRelMse:
            json["rel_mse"] = error.value;
            json["rel_mse_interval"] = {interval.low, interval.high};
            break;
        case QualityTarget::Metric::kSsim:
            json["ssim"] = 1.0 - error.value;
            json["ssim_interval"] = {1.0 - interval.high, 1.0 - interval.low};
            break;
        case QualityTarget::Metric::kIrradianceRel:
            json["irradiance_rel"] = std::sqrt(error.value);
            json["irradiance_rel_interval"] = {std::sqrt(interval.low), std::sqrt(interval.high)};
            break;
        default: {
            const ErrorFigures figures = figures_of(error);
            json["rmse"] = figures.rmse;
            json["rmse_interval"] = {figures.rmse_interval.low, figures.rmse_interval.high};
            json["psnr_db"] = optional_json(figures.psnr_db);
            json["psnr_db_interval"] = {optional_json(figures.psnr_low_db),
                                        optional_json(figures.psnr_high_db)};
        }
    }
}

/// What is known of a probe's error: its own audit's figures, and in their place, where there are
/// any, those that the job's other audits took part in.
Json write_probe_error(const JobSpec& job, const ProbeResult& result) {
    const bool spared = result.certificate.pixels == 0;
    const Json own =
        spared ? Json::object() : write_error(result.certificate.error, result.confidence);
    Json json = own;
    json["confidence"] = job.quality.evidence.confidence;
    for (size_t t = 0; t < result.pooled.size(); ++t) {
        if (!result.pooled[t]) continue;
        tell(json, job.quality.targets[t].metric, *result.pooled[t]);
        if (spared) continue;
        json["own_audit"] = own;
        json["own_audit"]["confidence"] = result.confidence;
    }
    return json;
}

Json write_curve(const Pilot& pilot, double confidence) {
    Json curve = Json::array();
    for (const CurvePoint& point : pilot.curve) {
        Json json = {{"settings", write_settings(point.settings)},
                     {"chosen", point.settings == pilot.settings},
                     {"pixels", pilot.pixels},
                     {"rays", point.rays},
                     {"steps", point.steps},
                     {"seconds", point.seconds}};
        json["error"] = write_error(point.error, confidence);
        curve.push_back(std::move(json));
    }
    return curve;
}

std::string_view name_of(Expectation expectation) {
    constexpr std::array<std::string_view, 3> kNames = {"target_met", "budget_exhausted",
                                                        "unreachable"};
    return kNames[static_cast<size_t>(expectation)];
}

struct Costs {
    CostStats render;
    CostStats earlier_renders;
    CostStats pilot;
    CostStats audit;
    uint64_t pixels = 0;

    void add(const ProbeResult& result) {
        render += result.render_cost();
        earlier_renders += result.earlier_renders;
        audit += result.decision_cost;
        audit += result.certificate.cost;
        for (const uint64_t face : result.pixels) pixels += face;
    }
    void add(const Pilot& of) {
        pilot += of.search_cost;
        pilot += of.curve_cost;
    }
    /// By counted steps: a share that does not hang on the machine.
    static double share(const CostStats& part, const CostStats& render) {
        return render.counted() > 0
                   ? static_cast<double>(part.counted()) / static_cast<double>(render.counted())
                   : 0.0;
    }
    Json write() const {
        const auto per_pixel = [&](uint64_t rays) {
            return pixels > 0 ? static_cast<double>(rays) / static_cast<double>(pixels) : 0.0;
        };
        return {{"pixels", pixels},
                {"render", write_cost_with_levels(render)},
                {"rays_per_pixel", per_pixel(render.all_rays())},
                {"earlier_renders", write_cost(earlier_renders)},
                {"pilot", write_cost(pilot)},
                {"pilot_steps_over_render", share(pilot, render)},
                {"audit", write_cost(audit)},
                {"audit_steps_over_render", share(audit, render)}};
    }
};

Json write_files(std::span<const ProductFile> files) {
    Json json = Json::array();
    for (const ProductFile& file : files) {
        json.push_back({{"name", file.name}, {"bytes", file.size_bytes}, {"sha256", file.sha256}});
    }
    return json;
}

Json write_lighting(const StateLight& light) {
    const LightingCost& cost = light.cost;
    Json json = {{"faces", cost.faces},
                 {"sun_rays", cost.sun_rays},
                 {"sky_gatherings", cost.gatherings},
                 {"sky_rays", cost.sky_rays},
                 {"steps", cost.steps},
                 {"seconds", cost.seconds},
                 {"wall_seconds", cost.wall_seconds},
                 {"bytes", cost.memory_bytes},
                 {"from_cache", cost.from_cache}};
    if (!light.sky_sha256.empty()) json["sky_sha256"] = light.sky_sha256;
    return json;
}

/// How actual errors compare with predicted ones, as the units were baked with.
Json write_steering(const Pilot& pilot) {
    Json json = Json::array();
    for (const std::optional<Steering>& target : pilot.steering) {
        if (!target) continue;
        json.push_back({{"predicted_mse_goal", target->goal},
                        {"actual_over_predicted", target->prior.ratio},
                        {"spread", target->prior.spread},
                        {"draw_cv", target->prior.draw_cv}});
    }
    return json;
}

Json write_emitters(const EmitterPilot& pilot) {
    return {{"voxels", pilot.emitters},
            {"sampled", pilot.sampled},
            {"reason", pilot.reason},
            {"variance_times_cost", pilot.variance_sampled * pilot.cost_sampled},
            {"variance_times_cost_without", pilot.variance_found * pilot.cost_found}};
}

/// What the pilot found of the media: the tracker, its rivals, the depths that were tried.
Json write_media(const MediaState& media) {
    const TrackerPilot& pilot = media.tracker_pilot;
    Json json = {{"tracker", name_of(pilot.choice.tracker)},
                 {"transmittance", name_of(pilot.choice.transmittance)},
                 {"reason", pilot.choice.reason},
                 {"rivals", Json::array()},
                 {"octree_depths", Json::array()}};
    for (const PilotRow& row : pilot.rows) {
        json["rivals"].push_back({{"tracker", name_of(row.tracker)},
                                  {"variance", row.variance},
                                  {"cost", row.cost},
                                  {"variance_times_cost", row.product()}});
    }
    for (const auto& [depth, cost] : media.depth.costs) {
        json["octree_depths"].push_back(
            {{"depth", depth}, {"cost", cost}, {"chosen", depth == media.depth.max_depth}});
    }
    if (media.emitter_pilot) json["emissive_voxels"] = write_emitters(*media.emitter_pilot);
    return json;
}

Json write_state(const BakeRecord& record, const Pilot& pilot) {
    const double confidence = record.job.quality.evidence.confidence;
    const MeasuredError pooled = pooled_error(record, pilot.state.spec);
    std::map<std::string, uint64_t> verdicts;
    Costs costs;
    costs.add(pilot);
    for (const ProbeResult& result : record.results) {
        if (result.state.id != pilot.state.spec.id) continue;
        ++verdicts[std::string(name_of(judge(record.job, pilot, result, pooled).verdict))];
        costs.add(result);
    }
    Json json = {{"state", name_of(pilot.state.spec)},
                 {"exposure", pilot.exposure},
                 {"settings", write_settings(pilot.settings)},
                 {"expectation", name_of(pilot.expectation)},
                 {"pilot",
                  {{"pixels", pilot.pixels},
                   {"candidates", pilot.candidates},
                   {"truth_grid", pilot.truth_grid},
                   {"steering", write_steering(pilot)},
                   {"wall_seconds", pilot.wall_seconds}}},
                 {"results", verdicts},
                 {"cost", costs.write()},
                 {"curve", write_curve(pilot, confidence)}};
    if (pilot.media) {
        json["media"] = write_media(*pilot.media);
        json["pilot"].erase("truth_grid");
        if (pilot.state.light && !pilot.state.light->sky_sha256.empty()) {
            json["media"]["sky_sha256"] = pilot.state.light->sky_sha256;
        }
    } else if (pilot.state.light) {
        json["lighting"] = write_lighting(*pilot.state.light);
    }
    Json error = pooled.mse.samples > 0 ? write_error(pooled, confidence) : Json::object();
    const auto known = state_errors(record, pilot);
    for (size_t t = 0; t < known.size(); ++t) {
        if (known[t]) tell(error, record.job.quality.targets[t].metric, *known[t]);
    }
    if (!error.empty()) {
        error["evidence"] = name_of(EvidenceOf::kJob);
        json["error"] = std::move(error);
    }
    return json;
}

}  // namespace

Json write_scene(const Scene& scene) {
    const VoxelTree& tree = scene.tree;
    const SceneLoadStats& load = scene.load;
    Json json = {{"name", scene.name},
                 {"sha256", scene.sha256},
                 {"author", scene.author},
                 {"licence", scene.licence},
                 {"voxel_size_m", scene.voxel_size_m},
                 {"corner_m", {scene.corner_m.x, scene.corner_m.y, scene.corner_m.z}},
                 {"depth", tree.depth()},
                 {"voxels", tree.voxel_count()},
                 {"octree_nodes", tree.octree_node_count()},
                 {"bytes", scene.memory_bytes()},
                 {"load",
                  {{"seconds", load.total_seconds},
                   {"from_cache", load.from_cache},
                   {"import_seconds", load.import_seconds},
                   {"sort_seconds", load.build.sort_seconds},
                   {"tree_seconds", load.build.tree_seconds},
                   {"color_seconds", load.build.color_seconds},
                   {"build_peak_bytes", load.build.peak_bytes}}}};
    if (scene.mesh) json["mesh"] = write_mesh_world(*scene.mesh);
    return json;
}

Json write_probe_row(const BakeRecord& record, const Pilot& pilot, const ProbeResult& result,
                     const MeasuredError& pooled) {
    const ProbeSpec& probe = record.job.probes[result.probe];
    const Judgement judgement = judge(record.job, pilot, result, pooled);
    Costs costs;
    costs.add(result);
    Json json = {{"probe", probe.id},
                 {"state", name_of(result.state)},
                 {"result", name_of(judgement.verdict)},
                 {"evidence", name_of(judgement.evidence)},
                 {"position_m", {probe.position_m.x, probe.position_m.y, probe.position_m.z}},
                 {"face_size_px", probe.face_size_px},
                 {"near_m", probe.near_m},
                 {"far_m", result.far_m},
                 {"inside_voxel", result.inside_voxel},
                 {"settings", write_settings(result.settings)},
                 {"looks", result.looks},
                 {"limited", result.limited},
                 {"wall_seconds", result.wall_seconds},
                 {"faces", Json::array()}};
    json["cost"] = costs.write();
    json["cost"].erase("pilot");
    json["cost"].erase("pilot_steps_over_render");
    for (size_t f = 0; f < kFaceCount; ++f) {
        Json face = write_cost_with_levels(result.faces[f]);
        face["face"] = kFaceNames[f];
        face["pixels"] = result.pixels[f];
        json["faces"].push_back(std::move(face));
    }
    if (result.audited()) json["error"] = write_probe_error(record.job, result);
    if (probe.place) json["validity"] = write_place(*probe.place);
    json["files"] = write_files(result.files);
    return json;
}

Json write_grid_row(const GridResult& result) {
    return {{"grid", result.grid}, {"state", result.state}, {"files", write_files(result.files)}};
}

Json provenance(int threads) {
    return {{"version", PROBEBAKE_VERSION}, {"compiler", "g++ " __VERSION__},
            {"kernel", "scalar"},           {"instruction_set", "x86-64-v2"},
            {"cpu", cpu_model()},           {"threads", threads}};
}

Json write_report(const BakeRecord& record) {
    Costs costs;
    std::vector<std::string> warnings = record.plan.warnings;
    warnings.insert(warnings.end(), record.warnings.begin(), record.warnings.end());
    uint64_t bytes = 0;
    uint64_t floats = 0;
    for (const ProbeResult& result : record.results) {
        costs.add(result);
        floats += result.is_float ? 1 : 0;
        for (const ProductFile& file : result.files) bytes += file.size_bytes;
    }
    if (floats > 0) {
        warnings.push_back(std::to_string(floats) +
                           " cubemaps are FLOAT: they hold values above 65504");
    }
    uint64_t float_atlases = 0;
    for (const GridResult& result : record.grid_results) {
        float_atlases += result.is_float ? 1 : 0;
        for (const ProductFile& file : result.files) bytes += file.size_bytes;
    }
    if (float_atlases > 0) {
        warnings.push_back(std::to_string(float_atlases) +
                           " atlases of irradiance are FLOAT: they hold values above 65504");
    }
    if (const uint64_t faults = costs.render.media.faults; faults > 0) {
        warnings.push_back(std::to_string(faults) +
                           " paths through media were faults: given up, or beyond their bounds");
    }
    const QualitySpec& quality = record.job.quality;
    Json targets = Json::array();
    for (const QualityTarget& target : quality.targets) {
        targets.push_back({{"metric", name_of(target.metric)}, {"value", target.value}});
    }
    Json states = Json::array();
    for (const Pilot& pilot : record.pilots) {
        costs.add(pilot);
        states.push_back(write_state(record, pilot));
    }
    return {{"effective_request", write_job(record.job)},
            {"scene", write_scene(record.scene)},
            {"plan", write_plan(record.plan)},
            {"target",
             {{"targets", std::move(targets)},
              {"require", kRequireNames[static_cast<size_t>(quality.require)]},
              {"against", name_of(quality.against)},
              {"confidence", quality.evidence.confidence},
              {"weighting", kWeightingNames[static_cast<size_t>(quality.weighting)]}}},
            {"validity", write_places(record.job, record.places)},
            {"states", std::move(states)},
            {"totals",
             {{"cubemaps", record.results.size()},
              {"bytes", bytes},
              {"cost", costs.write()},
              {"wall_seconds", record.wall_seconds},
              {"seconds_to_first_probe", record.seconds_to_first_probe},
              {"peak_memory_bytes", record.peak_memory_bytes}}},
            {"deterministic", !record.job.budget.seconds.has_value()},
            {"warnings", warnings},
            {"provenance", provenance(record.threads)}};
}

std::optional<std::string> budget_failure(const JobSpec& job, const Json& report) {
    if (job.on_budget_exhausted == OnBudgetExhausted::kReturnBest) return std::nullopt;
    const std::string verdict(name_of(Verdict::kBudgetExhausted));
    uint64_t count = 0;
    for (const Json& state : report.at("states")) {
        count += state.at("results").value(verdict, uint64_t{0});
    }
    if (count == 0) return std::nullopt;
    return "the budget was used up before " + std::to_string(count) +
           " cubemaps met their target; what it allowed is in the files";
}

}  // namespace probebake
