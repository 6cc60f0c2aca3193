// Plots of a study: data, gnuplot scripts, and SVG files where gnuplot is installed.
#pragma once

#include <filesystem>
#include <string>

#include "io/json.h"

namespace probebake::study {

/// Writes NAME.dat and NAME.gp into the folder and runs gnuplot on them. False where there is none
/// or it failed. `note` ends every title (the size of a reduced run).
bool write_plots(const std::filesystem::path& folder, const Json& results, const std::string& note);

/// Runs gnuplot on a script in a folder, which is where it works. False where there is none or it
/// failed.
bool run_gnuplot(const std::filesystem::path& folder, const std::string& script);

}  // namespace probebake::study
