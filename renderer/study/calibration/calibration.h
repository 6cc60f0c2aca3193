// The study of promises: whether baked probes meet their target, whether the intervals of their
// audits hold their true error, and what both cost.
//
// Jobs as clients send them are baked in memory on generated and real scenes, unlit and lit, at
// three face sizes; every pixel of every probe is then compared with two independent means of
// 16 × 16 leaf rays, and with what brute force finds: the cheapest price at which the probe, and
// the cheapest at which 95 % of its job's probes, would have met the target. Finished jobs are
// files in OUT/results; tables go to OUT/tables and all of it into OUT/report.md.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/json.h"
#include "study/study.h"

namespace probebake::study {

struct CalibrationParams {
    std::filesystem::path out;
    int size = 512;                   // of generated worlds, a power of two
    double share = 1.0;               // of the probes of a full run
    std::vector<std::string> scenes;  // names; empty: all
    std::vector<int> faces;           // face sizes of 16, 32, 64; empty: all
    std::optional<int> probes_per_job;
    std::optional<std::filesystem::path> data_folder;
    std::optional<std::filesystem::path> cache_folder;
};

struct CalibrationOutcome {
    uint64_t computed = 0;  // jobs
    uint64_t found = 0;
    std::vector<std::string> left_out;
    Json results;  // results[job]
    Json summary;  // summary[group], of all and of parts: calibration_report.h
};

/// Throws as run_study does. Parallel on the calling arena.
CalibrationOutcome run_calibration(const CalibrationParams& params,
                                   const std::function<void(const StudyProgress&)>& on_progress);

std::vector<std::string> calibration_scene_names();

}  // namespace probebake::study
