// What the thesis says, and whether it is so here.
#pragma once

#include <string>
#include <vector>

#include "io/json.h"
#include "study/text_table.h"

namespace probebake::study {

/// Claims, verdicts and where, as far as the experiments ran.
TextTable claims_table(const Json& results);

}  // namespace probebake::study
