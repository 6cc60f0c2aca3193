#include "study/experiment.h"

#include "scene/suggest_probes.h"
#include "study/experiments.h"

namespace probebake::study {
namespace {

bool on_views(const StudyScene& scene) { return scene.kind != SceneKind::kQuestion; }
bool on_terrains_and_worlds(const StudyScene& scene) {
    return scene.kind == SceneKind::kTerrain || scene.kind == SceneKind::kWorld;
}
bool on_terrains(const StudyScene& scene) { return scene.kind == SceneKind::kTerrain; }
bool on_cornell(const StudyScene& scene) { return scene.name == "cornell"; }
bool on_thin_things(const StudyScene& scene) {
    return scene.name == "slackline" || scene.name == "torch";
}

Json no_params() { return Json::object(); }
Json probe_params() { return {{"probes", kProbeCount}, {"face_px", kProbeFace_px}}; }

Json thin_params() { return {{"shifts", 1024}}; }

constexpr std::array<Experiment, 11> kExperiments = {{
    {"rendering", "Ray and step counts, classes, quality", on_views, no_params, run_rendering},
    {"threshold_decay", "Threshold and decay", on_terrains_and_worlds, no_params,
     run_threshold_decay},
    {"thresholds", "Thresholds", on_terrains_and_worlds, no_params, run_thresholds},
    {"equal_steps", "Equal steps", on_views, no_params, run_equal_steps},
    {"resolutions", "Resolutions", on_terrains_and_worlds, no_params, run_resolutions},
    {"probes", "Light probes", on_views, probe_params, run_probes},
    {"times_of_day", "Times of day", on_terrains, times_of_day_params, run_times_of_day},
    {"beam", "Cornell beam", on_cornell, no_params, run_beam},
    {"shadow_rays", "Shadow rays", on_views, no_params, run_shadow_rays},
    {"walls", "Walls between lit and dark", on_views, no_params, run_walls},
    {"thin", "Slackline and torch", on_thin_things, thin_params, run_thin},
}};

}  // namespace

const Scene& SceneWork::scene() {
    if (!scene_) {
        scene_ = std::make_unique<Scene>(load_scene(study_scene_.file, cache_folder_));
    }
    return *scene_;
}

const RecordSet& SceneWork::nadir() {
    if (!nadir_) {
        nadir_ = std::make_unique<RecordSet>(albedo_of(scene()), study_view(scene(), size_));
    }
    return *nadir_;
}

const std::vector<Vec3>& SceneWork::probe_positions_m() {
    if (positions_m_.empty()) positions_m_ = suggest_probes(scene(), kProbeCount);
    return positions_m_;
}

const RecordSet& SceneWork::probes() {
    if (!probes_) {
        std::vector<Vec3> positions;
        for (const Vec3& p : probe_positions_m()) positions.push_back(scene().to_voxels(p));
        probes_ = std::make_unique<RecordSet>(albedo_of(scene()), positions, kProbeFace_px);
    }
    return *probes_;
}

std::span<const Experiment> experiments() { return kExperiments; }

}  // namespace probebake::study
