// A report for people: the table of cost and error per probe, and what stands above it.
#pragma once

#include <string>
#include <vector>

#include "io/json.h"

namespace probebake {

/// From the JSON of report and rows, as the service delivers them.
std::string report_text(const Json& report, const std::vector<Json>& rows);

}  // namespace probebake
