#include "study/study.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "error/node_error.h"
#include "study/experiments.h"
#include "study/report.h"
#include "study/result_store.h"

namespace probebake::study {
namespace {

/// Changes whenever an experiment measures something else.
constexpr int kStudyVersion = 1;
constexpr const char* kNormaliser = "normaliser";

void check(const StudyParams& params) {
    if (params.size < kSmallestSize || params.size > kFullSize ||
        !std::has_single_bit(static_cast<unsigned>(params.size))) {
        throw std::invalid_argument("expected a size that is a power of two from " +
                                    std::to_string(kSmallestSize) + " to " +
                                    std::to_string(kFullSize));
    }
    const auto check_names = [](const std::vector<std::string>& asked,
                                const std::vector<std::string>& known, const char* what) {
        for (const std::string& name : asked) {
            if (std::find(known.begin(), known.end(), name) != known.end()) continue;
            std::string message = std::string("there is no ") + what + " " + name;
            const char* separator = "; expected one of ";
            for (const std::string& k : known) {
                message.append(separator).append(k);
                separator = ", ";
            }
            throw std::invalid_argument(message);
        }
    };
    check_names(params.scenes, scene_names(), "scene");
    check_names(params.experiments, experiment_names(), "experiment");
}

bool asked_for(const std::vector<std::string>& names, const std::string& name) {
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

class StudyRun {
  public:
    StudyRun(const StudyParams& params,
             const std::function<void(const StudyProgress&)>& on_progress)
        : params_(params),
          on_progress_(on_progress),
          store_(params.out / "results"),
          scenes_(study_scenes(params.size, params.data_folder)) {
        std::filesystem::create_directories(params.out / "pictures");
    }

    StudyOutcome run() {
        plan();
        if (asked_for(params_.experiments, "rendering")) {
            find_normalisers(params_.scenes.empty());
        }
        for (const StudyScene& scene : scenes_) {
            if (!asked_for(params_.scenes, scene.name)) continue;
            if (scene.missing) {
                outcome_.left_out.push_back(scene.name + ": no " + *scene.missing +
                                            " in the folder of real data (PROBEBAKE_DATA)");
                continue;
            }
            run_scene(scene);
        }
        return std::move(outcome_);
    }

  private:
    void plan() {
        for (const StudyScene& scene : scenes_) {
            if (!asked_for(params_.scenes, scene.name) || scene.missing) continue;
            for (const Experiment& experiment : experiments()) {
                if (runs(experiment, scene)) ++total_;
            }
        }
    }
    bool runs(const Experiment& experiment, const StudyScene& scene) const {
        return asked_for(params_.experiments, experiment.name) && experiment.applies(scene);
    }
    void progress(const std::string& what) {
        on_progress_({what, outcome_.computed + outcome_.found, total_});
    }

    Json key_of(const std::string& experiment, const StudyScene& scene, const Json& params) const {
        return {{"version", kStudyVersion},
                {"experiment", experiment},
                {"scene", content_sha256(scene.file)},
                {"size", params_.size},
                {"threshold", kThesisThreshold},
                {"decay", kThesisDecay},
                {"params", params}};
    }

    /// The terrains' common normalisers. Where only some scenes are asked for they are taken from
    /// an earlier run, or left out: a part of the study does not load all terrains.
    void find_normalisers(bool compute) {
        GlobalNormalisers found;
        double largest = 0.0;
        for (const StudyScene& scene : scenes_) {
            if (scene.kind != SceneKind::kTerrain) continue;
            const Json key = key_of(kNormaliser, scene, Json::object());
            const std::string name = std::string(kNormaliser) + "-" + scene.name;
            std::optional<Json> result = store_.find(name, key);
            if (!result && !compute) return;
            if (!result) {
                progress("normaliser, " + scene.name);
                SceneWork work(scene, params_.size, params_.cache_folder);
                result = measure_normaliser(work);
                store_.put(name, key, *result);
            }
            largest = std::max(largest, result->at("largest_variation").get<double>());
            if (!found.desert) found.desert = result->at("solved").get<double>();
        }
        found.largest = largest;
        normalisers_ = found;
    }

    void run_scene(const StudyScene& scene) {
        SceneWork work(scene, params_.size, params_.cache_folder);
        for (const Experiment& experiment : experiments()) {
            if (!runs(experiment, scene)) continue;
            Json parameters = experiment.params();
            if (std::string_view(experiment.name) == "rendering") {
                parameters = {{"largest", normalisers_.largest.value_or(0.0)},
                              {"desert", normalisers_.desert.value_or(0.0)}};
            }
            const Json key = key_of(experiment.name, scene, parameters);
            const std::string name = std::string(experiment.name) + "-" + scene.name;
            std::optional<Json> result = store_.find(name, key);
            if (result) {
                ++outcome_.found;
            } else {
                progress(std::string(experiment.name) + ", " + scene.name);
                const auto part = [&](const std::string& part_name,
                                      const std::function<Json()>& compute) {
                    const std::string file = std::string(name).append(".").append(part_name);
                    std::optional<Json> found = store_.find(file, key);
                    if (!found) {
                        progress(std::string(experiment.name) + ", " + scene.name + ", part " +
                                 part_name);
                        found = compute();
                        store_.put(file, key, *found);
                    }
                    return *found;
                };
                result = experiment.run({work, normalisers_, params_.out / "pictures", part});
                store_.put(name, key, *result);
                ++outcome_.computed;
            }
            outcome_.results[experiment.name][scene.name] = std::move(*result);
        }
    }

    const StudyParams& params_;
    const std::function<void(const StudyProgress&)>& on_progress_;
    ResultStore store_;
    std::vector<StudyScene> scenes_;
    GlobalNormalisers normalisers_;
    uint64_t total_ = 0;
    StudyOutcome outcome_;
};

}  // namespace

std::vector<std::string> experiment_names() {
    std::vector<std::string> names;
    for (const Experiment& experiment : experiments()) names.emplace_back(experiment.name);
    return names;
}

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const StudyScene& scene : study_scenes(kFullSize, std::nullopt)) {
        names.push_back(scene.name);
    }
    return names;
}

StudyOutcome run_study(const StudyParams& params,
                       const std::function<void(const StudyProgress&)>& on_progress) {
    check(params);
    StudyOutcome outcome = StudyRun(params, on_progress).run();
    write_report(params, outcome);
    return outcome;
}

}  // namespace probebake::study
