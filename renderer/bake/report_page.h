// The report as a page to look at: the curve of error against run time of every state, log-log,
// with its target, and the figures beside it.
//
// One self-contained HTML document with inline SVG: no scripts, nothing loaded from elsewhere,
// every text from the report escaped. Made from the JSON alone (docs/report.md), so that a
// downloaded report gives the same page as the service.
#pragma once

#include <string>

#include "io/json.h"

namespace probebake {

/// Throws SpecError (malformed) for a JSON that is no report.
std::string report_page(const Json& report);

}  // namespace probebake
