// Lines with points, as gnuplot's files and, where gnuplot is installed, an SVG.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace probebake::volume_study {

struct PlotPoint {
    double x;
    double y;
};
struct PlotLine {
    std::string name;
    std::vector<PlotPoint> points;
};
struct LinePlot {
    std::string name;  // of the files
    std::string title;
    std::string x_label;
    std::string y_label;
    std::string log_axes;  // "xy", "y", "x" or none
    std::vector<PlotLine> lines;
};

/// Writes NAME.dat and NAME.gp and runs gnuplot on them. False where there is none.
bool write_plot(const std::filesystem::path& folder, const LinePlot& plot);

}  // namespace probebake::volume_study
