// Pictures of clouds by single trackers: figures 6 and 7 of the supplemental, and error against run
// time.
#pragma once

#include "volume_study/clouds.h"

namespace probebake::volume_study {

struct FigureParams {
    int side = 32;         // pixels
    int reference = 1024;  // samples of a pixel of each of the two references
    std::filesystem::path out;
};

/// Figure 6: history-aware average with free-path-sampling coefficients of f × the majorant, with
/// and without absorption, pixels clamped at 65504. Writes figure_6.png.
study::TextTable unbounded_table(const Cloud& cloud, const FigureParams& params);

/// Figure 7: history-aware maximum and average at equal cost, albedo 1, 16 samples a pixel. Writes
/// figure_7.png: maximum, average, reference.
study::TextTable schemes_table(const Cloud& cloud, const FigureParams& params);

/// RMSE against run time, every tracker on every medium at 1 to 256 samples a pixel. Writes one
/// error_against_time_MEDIUM.svg each where gnuplot is installed.
study::TextTable curve_table(const Cloud& cloud, const FigureParams& params,
                             const std::function<void(const std::string&)>& progress);

}  // namespace probebake::volume_study
