// Where the thesis's tables contradict each other or what is possible, found by computing.
#pragma once

#include <string>
#include <vector>

#include "study/thesis_tables.h"

namespace probebake::study {

/// One finding per line of text, the computed figures in it.
std::vector<std::string> thesis_inconsistencies();

/// The error-aware renderer's RMSE over the adaptive one's in the thesis's own 20 cases (4 areas,
/// albedo and 4 times of day), and in how many of them it takes no more steps.
struct ThesisOwnCases {
    double lowest_ratio = 0.0;
    double highest_ratio = 0.0;
    double mean_ratio = 0.0;
    int cases = 0;
    int cheaper_or_equal = 0;
};
ThesisOwnCases thesis_own_cases();

/// Rays of an error-aware view of the desert that hit: one per pixel at least, 21 at most.
struct PossibleRays {
    uint64_t fewest = 0;
    uint64_t most = 0;
};
PossibleRays possible_desert_rays();

}  // namespace probebake::study
