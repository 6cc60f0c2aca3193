// Tables, plots and the report of a study, from its results alone.
#pragma once

#include "study/study.h"

namespace probebake::study {

/// Writes OUT/tables, OUT/plots and OUT/report.md; sets outcome.plotted.
void write_report(const StudyParams& params, StudyOutcome& outcome);

}  // namespace probebake::study
