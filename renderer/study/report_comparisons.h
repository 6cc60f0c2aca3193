// The tables of single comparisons: equal steps, times of day, the beam, thin things.
#pragma once

#include "study/report_cells.h"

namespace probebake::study {

/// RMSE of error-aware over adaptive by budget; `experiment` holds rows of measure_equal_steps.
TextTable equal_steps_table(const Json& experiment, const std::string& name,
                            const std::string& title, const char* against);
/// The thresholds that meet the budgets.
TextTable budget_thresholds_table(const Json& experiment);
/// Where both cost as much as the thesis's do: figures of all renderers, and their ratios.
TextTable thesis_cost_table(const Json& experiment);
TextTable thesis_cost_ratios_table(const Json& experiment, bool with_thesis);
TextTable times_table(const Json& experiment, bool with_thesis);
std::vector<TextTable> beam_tables(const Json& experiment);
TextTable thin_table(const Json& experiment);

/// The row of measure_equal_steps whose cost is nearest to the thesis's.
const Json& thesis_cost_row(const Json& result);

}  // namespace probebake::study
