// Cells of the report: figures of results, and the thesis's beside ours.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/json.h"
#include "study/text_table.h"
#include "study/thesis_tables.h"

namespace probebake::study {

/// The row of `renderer` in a list of them.
const Json& renderer_row(const Json& renderers, const std::string& renderer);
/// A figure of a row, against "reference" or "truth".
inline double rmse_of(const Json& row, const char* against) {
    return row.at(against).at("rmse").get<double>();
}
inline double steps_of(const Json& row) { return row.at("steps").get<double>(); }
inline double hit_rays_of(const Json& row) { return row.at("hit_rays").get<double>(); }
/// The shares of a row's classes of pixels (%), then PSNR (dB), SSIM and RMSE against the reference
/// and against the truth.
std::vector<std::string> class_and_error_cells(const Json& row);
std::optional<double> number_or_none(const Json& value);

/// The area that a scene stands for; null for the others.
const ThesisArea* thesis_area(const std::string& scene);
double ratio(uint64_t a, uint64_t b);
/// Without trailing zeros, at most three decimals.
std::string text_of(double x);
/// Beside a figure of ours the thesis's, in brackets.
std::string beside(const std::string& ours, bool with_thesis, std::optional<double> thesis,
                   int count);
/// A title that says whose the figures in brackets are, where there are any.
std::string titled(const std::string& title, bool with_thesis, const std::string& thesis);

}  // namespace probebake::study
