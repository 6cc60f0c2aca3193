// One experiment of the study on one scene: what it needs, and a function from that to a result.
//
// Results are JSON, so that the report is made from files alone. Each experiment has a file of its
// own; experiments() lists them in the order of the report.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>

#include "io/json.h"
#include "study/record_set.h"
#include "study/study_scenes.h"

namespace probebake::study {

/// What the experiments of a scene share, made when it is first asked for.
class SceneWork {
  public:
    SceneWork(const StudyScene& scene, int size,
              const std::optional<std::filesystem::path>& cache_folder)
        : study_scene_(scene), size_(size), cache_folder_(cache_folder) {}

    const StudyScene& study_scene() const { return study_scene_; }
    int size() const { return size_; }
    const Scene& scene();
    /// The study view.
    const RecordSet& nadir();
    /// Cubemaps of 64² pixels per face at suggested positions.
    const RecordSet& probes();
    const std::vector<Vec3>& probe_positions_m();

  private:
    const StudyScene& study_scene_;
    int size_;
    std::optional<std::filesystem::path> cache_folder_;
    std::unique_ptr<Scene> scene_;
    std::unique_ptr<RecordSet> nadir_;
    std::unique_ptr<RecordSet> probes_;
    std::vector<Vec3> positions_m_;
};

/// Normalisers of the adaptive renderer that hold for all scenes alike.
struct GlobalNormalisers {
    /// The largest variation on the four terrains: the thesis's normalisation, taken literally.
    std::optional<double> largest;
    /// With which the desert takes as many steps as the error-aware renderer there: what the
    /// thesis's own parameters amount to (5.1.4).
    std::optional<double> desert;
};

struct ExperimentInput {
    SceneWork& work;
    const GlobalNormalisers& normalisers;
    /// Pictures go here, named after experiment and scene.
    std::filesystem::path picture_folder;
    /// A part of a long experiment's result, kept in a file of its own as soon as it is known: an
    /// interrupted run goes on behind it. Computed only where there is none yet.
    std::function<Json(const std::string& name, const std::function<Json()>& compute)> part;
};

struct Experiment {
    const char* name;
    const char* title;
    bool (*applies)(const StudyScene& scene);
    /// Parameters the result depends on besides scene, size and normalisers.
    Json (*params)();
    Json (*run)(const ExperimentInput& input);
};
std::span<const Experiment> experiments();

/// The parts of `GlobalNormalisers` from one terrain: {"largest_variation", "solved"}.
Json measure_normaliser(SceneWork& work);

inline constexpr int kProbeCount = 4;
inline constexpr int kProbeFace_px = 64;

/// The thesis's steps of thresholds and decays (tables 5.1, 5.27), and two larger decays.
inline constexpr std::array<double, 6> kThresholds = {0.175, 0.15, 0.125, 0.1, 0.075, 0.05};
inline constexpr std::array<double, 8> kDecays = {0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.5, 1.0};
/// Costs at which renderers are compared, in steps of one ray per pixel at its level of detail.
inline constexpr std::array<double, 7> kBudgets = {1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 12.0};

/// What the thesis's settings cost it, rounded: 1.9 to 2.5 rays per pixel that hits (5.2-5.14).
inline constexpr double kThesisBudget = 2.0;

}  // namespace probebake::study
