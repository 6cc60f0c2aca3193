#include "study/calibration/calibration.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "study/calibration/calibrated_job.h"
#include "study/calibration/calibration_report.h"
#include "study/result_store.h"
#include "study/study_scenes.h"

namespace probebake::study {
namespace {

/// Changes whenever a job's result means something else.
constexpr int kCalibrationVersion = 1;

/// Jobs of every scene: unlit and lit ones of each face size, with so many probes.
struct FaceJobs {
    int face_size_px;
    int probes;
    double psnr_db;
    double lit_psnr_db;
};
constexpr std::array<FaceJobs, 3> kFaceJobs = {
    FaceJobs{16, 100, 35.0, 30.0}, FaceJobs{32, 32, 36.0, 31.0}, FaceJobs{64, 8, 38.0, 32.0}};
constexpr std::array<const char*, 8> kScenes = {"desert", "forest", "mountain", "biomes",
                                                "canopy", "net",    "worldA",   "lidar"};

std::vector<StudyScene> calibration_scenes(const CalibrationParams& params) {
    std::vector<StudyScene> scenes;
    for (StudyScene& scene : study_scenes(params.size, params.data_folder)) {
        if (std::find(kScenes.begin(), kScenes.end(), scene.name) != kScenes.end()) {
            scenes.push_back(std::move(scene));
        }
    }
    return scenes;
}

class CalibrationRun {
  public:
    CalibrationRun(const CalibrationParams& params,
                   const std::function<void(const StudyProgress&)>& on_progress)
        : params_(params), on_progress_(on_progress), store_(params.out / "results") {}

    CalibrationOutcome run() {
        const std::vector<StudyScene> scenes = calibration_scenes(params_);
        for (const StudyScene& scene : scenes) total_ += asked_for(scene) ? 2 * faces_asked() : 0;
        for (const StudyScene& scene : scenes) {
            if (!asked_for(scene)) continue;
            if (scene.missing) {
                outcome_.left_out.push_back(scene.name + ": no " + *scene.missing +
                                            " in the folder of real data (PROBEBAKE_DATA)");
                continue;
            }
            run_scene(scene);
        }
        outcome_.summary = summarise_calibration(outcome_.results);
        return std::move(outcome_);
    }

  private:
    bool asked_for(const StudyScene& scene) const {
        const auto& asked = params_.scenes;
        return asked.empty() || std::find(asked.begin(), asked.end(), scene.name) != asked.end();
    }
    bool asked_for(const FaceJobs& jobs) const {
        const auto& asked = params_.faces;
        return asked.empty() ||
               std::find(asked.begin(), asked.end(), jobs.face_size_px) != asked.end();
    }
    uint64_t faces_asked() const {
        return static_cast<uint64_t>(
            std::count_if(kFaceJobs.begin(), kFaceJobs.end(),
                          [&](const FaceJobs& jobs) { return asked_for(jobs); }));
    }

    void run_scene(const StudyScene& scene) {
        std::optional<Scene> loaded;
        for (const FaceJobs& jobs : kFaceJobs) {
            if (!asked_for(jobs)) continue;
            for (const bool lit : {false, true}) {
                const int probes = static_cast<int>(std::ceil(params_.share * jobs.probes));
                const CalibratedJob job{.face_size_px = jobs.face_size_px,
                                        .probes = probes,
                                        .probes_per_job = params_.probes_per_job,
                                        .lit = lit,
                                        .psnr_db = lit ? jobs.lit_psnr_db : jobs.psnr_db};
                const std::string name = scene.name + "-" + std::to_string(jobs.face_size_px) +
                                         (lit ? "-lit" : "-albedo");
                on_progress_({name, outcome_.computed + outcome_.found, total_});
                Json key = {{"version", kCalibrationVersion},
                            {"scene", content_sha256(scene.file)},
                            {"size", params_.size},
                            {"probes", probes},
                            {"psnr_db", job.psnr_db}};
                if (params_.probes_per_job) key["probes_per_job"] = *params_.probes_per_job;
                std::optional<Json> result = store_.find(name, key);
                if (result) {
                    ++outcome_.found;
                } else {
                    if (!loaded) loaded = load_scene(scene.file, params_.cache_folder);
                    result = calibrate_job(*loaded, job);
                    (*result)["scene"] = scene.name;
                    (*result)["face_size_px"] = job.face_size_px;
                    (*result)["lit"] = lit;
                    (*result)["psnr_db"] = job.psnr_db;
                    store_.put(name, key, *result);
                    ++outcome_.computed;
                }
                outcome_.results[name] = std::move(*result);
            }
        }
    }

    const CalibrationParams& params_;
    const std::function<void(const StudyProgress&)>& on_progress_;
    ResultStore store_;
    uint64_t total_ = 0;
    CalibrationOutcome outcome_;
};

}  // namespace

std::vector<std::string> calibration_scene_names() { return {kScenes.begin(), kScenes.end()}; }

CalibrationOutcome run_calibration(const CalibrationParams& params,
                                   const std::function<void(const StudyProgress&)>& on_progress) {
    if (params.size < kSmallestSize || params.size > kFullSize ||
        !std::has_single_bit(static_cast<unsigned>(params.size))) {
        throw std::invalid_argument("expected a size that is a power of two from " +
                                    std::to_string(kSmallestSize) + " to " +
                                    std::to_string(kFullSize));
    }
    for (const std::string& name : params.scenes) {
        if (std::find(kScenes.begin(), kScenes.end(), name) == kScenes.end()) {
            throw std::invalid_argument("there is no scene " + name);
        }
    }
    CalibrationOutcome outcome = CalibrationRun(params, on_progress).run();
    write_calibration_report(params, outcome);
    return outcome;
}

}  // namespace probebake::study
