// The report of the study of the default renderer, from its results alone.
#pragma once

#include "study/beyond/beyond.h"

namespace probebake::study {

/// Geometric means over the judged scenes: {"nadir": {...}, "probes": {...}, "irradiance": ...}.
Json summarise(const Json& results);

/// Fills in the outcome's summary; writes OUT/tables/*.csv and OUT/report.md.
void write_beyond_report(const BeyondParams& params, BeyondOutcome& outcome);

}  // namespace probebake::study
