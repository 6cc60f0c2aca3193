// The study: the experiments of Müller 2020 on all scenes, and the report.
//
// Finished results are files in OUT/results, one per experiment and scene; a run computes the ones
// that are missing or were made with other parameters, then writes tables (OUT/tables/*.csv), plots
// (OUT/plots), pictures (OUT/pictures) and OUT/report.md from the files alone.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/json.h"

namespace probebake::study {

/// The thesis's size. Smaller runs say so and show no figures of the thesis.
inline constexpr int kFullSize = 2048;
inline constexpr int kSmallestSize = 128;

struct StudyParams {
    std::filesystem::path out;
    int size = kFullSize;                  // a power of two
    std::vector<std::string> scenes;       // names; empty: all
    std::vector<std::string> experiments;  // names; empty: all
    std::optional<std::filesystem::path> data_folder;
    std::optional<std::filesystem::path> cache_folder;  // of scenes
};

struct StudyProgress {
    std::string what;  // experiment and scene
    uint64_t done = 0;
    uint64_t total = 0;
};

struct StudyOutcome {
    uint64_t computed = 0;
    uint64_t found = 0;  // results that were there already
    std::vector<std::string> left_out;
    bool plotted = false;  // gnuplot was there
    Json results;          // results[experiment][scene]
};

/// Throws std::invalid_argument for a bad size and for a scene or an experiment that does not
/// exist, IoError where the output cannot be written. Parallel on the calling arena.
StudyOutcome run_study(const StudyParams& params,
                       const std::function<void(const StudyProgress&)>& on_progress);

/// Names of all experiments and scenes, for help texts.
std::vector<std::string> experiment_names();
std::vector<std::string> scene_names();

}  // namespace probebake::study
