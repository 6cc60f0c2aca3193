#include "study/octrees/octree_study.h"

#include <algorithm>
#include <stdexcept>

#include "io/file.h"
#include "io/sha256.h"
#include "study/octrees/fluid_scene.h"
#include "study/octrees/octree_report.h"
#include "study/result_store.h"

namespace probebake::study {
namespace {

/// Changes whenever a scene's result means something else.
constexpr int kOctreeStudyVersion = 1;
constexpr int kSmallestOctreeSize_px = 8;

void check(const OctreeStudyParams& params) {
    for (const std::string& name : params.scenes) {
        if (std::find(kOctreeScenes.begin(), kOctreeScenes.end(), name) != kOctreeScenes.end()) {
            continue;
        }
        std::string message = "there is no scene " + name + "; expected one of";
        for (const char* known : kOctreeScenes) message += std::string(" ") + known;
        throw std::invalid_argument(message);
    }
    if (params.measure.size_px < kSmallestOctreeSize_px || params.measure.size_px > kSpdSize_px) {
        throw std::invalid_argument("expected a size from " +
                                    std::to_string(kSmallestOctreeSize_px) + " to " +
                                    std::to_string(kSpdSize_px) + " pixels");
    }
    const auto& depths = params.measure.depths;
    const auto in_tables = [](int depth) { return depth >= 4 && depth <= 7; };
    if (depths.empty() || !std::all_of(depths.begin(), depths.end(), in_tables) ||
        !std::is_sorted(depths.begin(), depths.end(), std::less_equal<>())) {
        throw std::invalid_argument("expected depths from 4 to 7 in rising order");
    }
}

/// The 1999 teapot is the larger one, of 9,264 polygons.
std::string file_of(const std::string& scene) {
    return scene == "teapot" ? "spd/teapot_s12.nff" : "spd/" + scene + ".nff";
}

}  // namespace

OctreeStudyOutcome run_octree_study(const OctreeStudyParams& params,
                                    const std::function<void(const StudyProgress&)>& on_progress) {
    check(params);
    const HavranTables tables(params.data_folder / "octrees/havran_1999.csv");
    const ResultStore store(params.out / "results");
    OctreeStudyOutcome outcome;
    const auto asked_for = [&](const std::string& name) {
        return params.scenes.empty() ||
               std::find(params.scenes.begin(), params.scenes.end(), name) != params.scenes.end();
    };
    const auto total =
        static_cast<uint64_t>(std::count_if(kOctreeScenes.begin(), kOctreeScenes.end(), asked_for));
    for (const std::string name : kOctreeScenes) {
        if (!asked_for(name)) continue;
        const bool generated = name == "fluid";
        const std::filesystem::path file = params.data_folder / file_of(name);
        if (!generated && !std::filesystem::exists(file)) {
            outcome.left_out.push_back(name + ": no " + file_of(name) + " in the data folder");
            continue;
        }
        const Json key = {{"version", kOctreeStudyVersion},
                          {"scene", generated ? "stand-in" : sha256_hex(read_file(file))},
                          {"size_px", params.measure.size_px},
                          {"depths", params.measure.depths}};
        std::optional<Json> result = store.find(name, key);
        if (result) {
            ++outcome.found;
        } else {
            const NffScene scene = generated ? fluid_stand_in() : read_nff(file);
            result = measure_scene(scene, params.measure, [&](const std::string& what) {
                on_progress({std::string(name).append(", ").append(what),
                             outcome.computed + outcome.found, total});
            });
            store.put(name, key, *result);
            ++outcome.computed;
        }
        outcome.results[name] = std::move(*result);
    }
    write_octree_report(params, tables, outcome);
    return outcome;
}

}  // namespace probebake::study
