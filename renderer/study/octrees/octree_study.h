// probebake study octrees: Havran's comparison of octree traversals of 1999, repeated.
//
// Finished scenes are files in OUT/results; a run measures what is missing and writes
// OUT/report.md, OUT/tables/*.csv and OUT/octrees.csv (every value in the form of the 1999 file,
// with that file's beside it) from them.
#pragma once

#include "study/octrees/havran_tables.h"
#include "study/octrees/measure.h"
#include "study/study.h"

namespace probebake::study {

struct OctreeStudyParams {
    std::filesystem::path out;
    /// Holds spd/*.nff and octrees/havran_1999.csv.
    std::filesystem::path data_folder;
    std::vector<std::string> scenes;  // names; empty: all
    MeasureParams measure;
};

/// The size whose figures per ray can be compared with those of 1999.
inline constexpr int kSpdSize_px = 512;

struct OctreeStudyOutcome {
    uint64_t computed = 0;
    uint64_t found = 0;
    std::vector<std::string> left_out;
    Json results;  // results[scene], as measure_scene makes them
    Json summary;
};

/// Throws std::invalid_argument for a scene that does not exist, a size or depths out of range,
/// IoError where files cannot be read or written. Parallel on the calling arena.
OctreeStudyOutcome run_octree_study(const OctreeStudyParams& params,
                                    const std::function<void(const StudyProgress&)>& on_progress);

}  // namespace probebake::study
