#include "study/beyond/beyond.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "study/beyond/beyond_report.h"
#include "study/beyond/error_fit.h"
#include "study/beyond/scene_comparison.h"
#include "study/result_store.h"
#include "study/study_scenes.h"

namespace probebake::study {
namespace {

/// Changes whenever a scene's result means something else.
constexpr int kBeyondVersion = 2;
constexpr uint64_t kFitSeed = 11;
constexpr std::array<uint64_t, 2> kFreshSeeds = {23, 41};

struct BeyondScene {
    StudyScene study;
    bool fit = false;
};

StudyScene terrain(const std::string& name, uint64_t seed, int size) {
    StudyScene scene{.name = name + "-" + std::to_string(seed), .kind = SceneKind::kTerrain};
    scene.file.name = scene.name;
    scene.file.generator = GeneratorParams{.name = name, .size = size, .seed = seed};
    scene.file.voxel_size_m = voxel_size_m(*scene.file.generator);
    scene.file.text =
        dump_json({{"type", "generator"}, {"generator", name}, {"size", size}, {"seed", seed}});
    return scene;
}

std::vector<BeyondScene> beyond_scenes(const BeyondParams& params) {
    std::vector<BeyondScene> scenes;
    for (const char* name : {"desert", "forest", "mountain"}) {
        scenes.push_back({terrain(name, kFitSeed, params.size), true});
    }
    for (const uint64_t seed : kFreshSeeds) {
        for (const char* name : {"desert", "forest", "mountain", "biomes"}) {
            scenes.push_back({terrain(name, seed, params.size), false});
        }
    }
    for (StudyScene& scene : study_scenes(params.size, params.data_folder)) {
        if (scene.kind == SceneKind::kWorld) scenes.push_back({std::move(scene), false});
    }
    for (const std::filesystem::path& file : params.vox) {
        StudyScene scene{.name = file.stem().string(), .kind = SceneKind::kWorld};
        scene.file.name = scene.name;
        scene.file.vox = file;
        scene.file.voxel_size_m = 0.25;
        scene.file.text = dump_json({{"vox", file.filename().string()}, {"voxel_size_m", 0.25}});
        scenes.push_back({std::move(scene), false});
    }
    return scenes;
}

class BeyondRun {
  public:
    BeyondRun(const BeyondParams& params,
              const std::function<void(const StudyProgress&)>& on_progress)
        : params_(params), on_progress_(on_progress), store_(params.out / "results") {}

    BeyondOutcome run() {
        const std::vector<BeyondScene> scenes = beyond_scenes(params_);
        for (const BeyondScene& scene : scenes) total_ += asked_for(scene) ? 1 : 0;
        std::vector<std::vector<RecordedPixel>> to_fit;
        size_t fits = 0;
        for (const BeyondScene& scene : scenes) {
            fits += scene.fit ? 1 : 0;
            if (!asked_for(scene)) continue;
            if (scene.study.missing) {
                outcome_.left_out.push_back(scene.study.name + ": no " + *scene.study.missing +
                                            " in the folder of real data (PROBEBAKE_DATA)");
                continue;
            }
            on_progress_({scene.study.name, outcome_.computed + outcome_.found, total_});
            if (scene.fit) {
                const Scene loaded = load_scene(scene.study.file, params_.cache_folder);
                to_fit.push_back(pixels_to_fit(loaded, comparison()));
                ++outcome_.computed;
            } else {
                judge(scene.study);
            }
        }
        if (to_fit.size() == fits) outcome_.fitted = fit_error_model(to_fit, kErrorModel);
        return std::move(outcome_);
    }

  private:
    bool asked_for(const BeyondScene& scene) const {
        const auto& asked = params_.scenes;
        return asked.empty() ||
               std::find(asked.begin(), asked.end(), scene.study.name) != asked.end();
    }
    ComparisonParams comparison() const { return {.size = params_.size, .probes = params_.probes}; }

    void judge(const StudyScene& scene) {
        Json model = Json::array();
        for (const auto& stage : kErrorModel) model.push_back(stage);
        const Json key = {{"version", kBeyondVersion},
                          {"scene", content_sha256(scene.file)},
                          {"size", params_.size},
                          {"probes", params_.probes},
                          {"error_model", std::move(model)}};
        std::optional<Json> result = store_.find(scene.name, key);
        if (result) {
            ++outcome_.found;
        } else {
            const Scene loaded = load_scene(scene.file, params_.cache_folder);
            result = compare_on_scene(loaded, comparison());
            store_.put(scene.name, key, *result);
            ++outcome_.computed;
        }
        outcome_.results[scene.name] = std::move(*result);
    }

    const BeyondParams& params_;
    const std::function<void(const StudyProgress&)>& on_progress_;
    ResultStore store_;
    uint64_t total_ = 0;
    BeyondOutcome outcome_;
};

}  // namespace

std::vector<std::string> beyond_scene_names() {
    std::vector<std::string> names;
    for (const BeyondScene& scene : beyond_scenes({})) names.push_back(scene.study.name);
    return names;
}

BeyondOutcome run_beyond(const BeyondParams& params,
                         const std::function<void(const StudyProgress&)>& on_progress) {
    if (params.size < kSmallestSize || params.size > kFullSize ||
        !std::has_single_bit(static_cast<unsigned>(params.size))) {
        throw std::invalid_argument("expected a size that is a power of two from " +
                                    std::to_string(kSmallestSize) + " to " +
                                    std::to_string(kFullSize));
    }
    BeyondOutcome outcome = BeyondRun(params, on_progress).run();
    write_beyond_report(params, outcome);
    return outcome;
}

}  // namespace probebake::study
