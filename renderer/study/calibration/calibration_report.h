// What the calibration study's jobs come to, in groups, and its report.
#pragma once

#include "study/calibration/calibration.h"

namespace probebake::study {

/// Figures of the rows of all jobs: of all of them (`all`), and by face size, light and scene.
Json summarise_calibration(const Json& results);

/// Chance of at most `hits` of n where each comes with `probability`: small where a share is
/// significantly less than that.
double binomial_tail(uint64_t hits, uint64_t n, double probability);

/// OUT/tables/*.csv and OUT/report.md.
void write_calibration_report(const CalibrationParams& params, const CalibrationOutcome& outcome);

}  // namespace probebake::study
