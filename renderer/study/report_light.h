// The report's tables about shadow rays and walls.
#pragma once

#include "io/json.h"
#include "study/text_table.h"

namespace probebake::study {

TextTable shadow_rays_table(const Json& experiment);
std::vector<TextTable> walls_tables(const Json& experiment);

}  // namespace probebake::study
