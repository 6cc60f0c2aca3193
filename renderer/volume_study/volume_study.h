// The study of media: the experiments of the supplemental of Kutz et al. 2017 on our clouds.
//
// Clouds: a density grid out of an OpenVDB file (Disney's cloud at 1/16), a generated cumulus; each
// thin and thick, that is with a largest vertical column of 3 and of 500 optical thicknesses.
// Counts are exact and repeatable; seconds are this machine's. Results: OUT/*.csv, *.svg, *.png and
// OUT/report.md.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "study/text_table.h"

namespace probebake::volume_study {

struct VolumeStudyParams {
    std::filesystem::path out;
    std::optional<std::filesystem::path> cloud;  // .vdb with a grid "density"
    int cumulus_size = 1024;                     // 0: none
    int paths = 2000;                  // per row of the depth tables, thin; an eighth of it thick
    int samples = 20000;               // per row of the others
    int side = 32;                     // pixels of the pictures of figures 6, 7 and the curves
    int reference = 1024;              // paths per pixel of each of their two references
    uint64_t most_nodes = 40'000'000;  // of an octree
    std::vector<std::string> experiments;  // of experiment_names(); empty: all
};

const std::vector<std::string>& experiment_names();

/// Tables of all experiments, also written to params.out. Throws std::invalid_argument for an
/// unknown experiment, IoError for files.
std::vector<study::TextTable> run_volume_study(
    const VolumeStudyParams& params, const std::function<void(const std::string&)>& on_progress);

}  // namespace probebake::volume_study
