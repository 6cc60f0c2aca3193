// The tables of the report, from the results of a study (study.h).
#pragma once

#include <vector>

#include "io/json.h"
#include "study/text_table.h"

namespace probebake::study {

/// A part of the report with its tables; none where its experiments did not run.
struct ReportSection {
    std::string title;
    std::string text;
    std::vector<TextTable> tables;
};

/// `with_thesis`: the run is as large as the thesis's, whose figures stand beside.
std::vector<ReportSection> report_sections(const Json& results, bool with_thesis);

}  // namespace probebake::study
