// The study of the default renderer: what it reaches beside the renderers of Müller 2020, on scenes
// that nothing was fitted on, and what each of its parts brings.
//
// The error model is fitted on three terrains and judged on others: fresh seeds of all terrains,
// worldA, the LiDAR terrain, and any .vox file that is given. Finished scenes are files in
// OUT/results; tables go to OUT/tables and all of it into OUT/report.md.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/json.h"
#include "render/error_model.h"
#include "study/study.h"

namespace probebake::study {

struct BeyondParams {
    std::filesystem::path out;
    int size = kFullSize;                    // of generated worlds, a power of two
    int probes = 8;                          // cubemaps of 64² per face, per scene
    std::vector<std::string> scenes;         // names; empty: all
    std::vector<std::filesystem::path> vox;  // judged as well, in voxels of 0.25 m
    std::optional<std::filesystem::path> data_folder;
    std::optional<std::filesystem::path> cache_folder;
};

struct BeyondOutcome {
    uint64_t computed = 0;
    uint64_t found = 0;
    std::vector<std::string> left_out;
    Json results;  // results[scene]
    Json summary;
    std::optional<ErrorModel> fitted;  // where all scenes to fit on were there
};

/// Throws as run_study does. Parallel on the calling arena.
BeyondOutcome run_beyond(const BeyondParams& params,
                         const std::function<void(const StudyProgress&)>& on_progress);

std::vector<std::string> beyond_scene_names();

}  // namespace probebake::study
