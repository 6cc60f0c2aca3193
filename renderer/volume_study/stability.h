// Stiff and extreme cases, one by one: what breaks renderers of media and voxels, and that it does
// not break ours.
//
// Every case states what is checked, the value found, its bound, and, where they are defined, the
// z-score of the bias against an exact answer and the variance of one sample. Cases that show a
// failure which a choice or guard avoids ("without the guard: …") pass where it shows. Results:
// OUT/stability.csv and OUT/stability.md.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "math/estimate.h"
#include "study/text_table.h"

namespace probebake::volume_study {

struct StabilityCase {
    std::string name;
    std::string checked;
    std::string value;
    std::string bound;
    bool pass = false;
    std::optional<double> z;
    std::optional<double> variance;
};

/// Four digits.
std::string short_text(double x);

/// A mean against its exact value: |z| < 4.5, which chance exceeds once in 150,000 cases.
StabilityCase unbiased(std::string name, std::string checked, const Moments& moments, double exact);
/// A number below (or, turned round, above) a bound. NaN fails.
StabilityCase at_most(std::string name, std::string checked, double value, double bound);
StabilityCase at_least(std::string name, std::string checked, double value, double bound);

/// Those of furnaces included.
std::vector<StabilityCase> media_cases();
std::vector<StabilityCase> furnace_cases();
/// `full`: also a room in cubes of 4096², which takes minutes.
std::vector<StabilityCase> voxel_cases(bool full = false);
/// Of numbers that are none, wherever a request or a file may hold one; those of .vdb files
/// included.
std::vector<StabilityCase> input_cases();
std::vector<StabilityCase> vdb_cases();

struct StabilityReport {
    study::TextTable table;
    int failed = 0;
};
/// Throws IoError for files.
StabilityReport run_stability_study(const std::filesystem::path& out, bool full,
                                    const std::function<void(const std::string&)>& on_progress);

}  // namespace probebake::volume_study
