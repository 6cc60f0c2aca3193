// A result's figures under the names and in the units of the 1999 tables.
#pragma once

#include <algorithm>

#include "io/json.h"
#include "study/octrees/havran_tables.h"

namespace probebake::study {

/// N_IT is per ray that hits, the others per ray, as the 1999 figures turn out to be; N_B and N_TR
/// are seconds of CPU time.
double octree_figure(const Json& result, const Json& row, const std::string& quantity);

/// The row of a method at a depth; null where it was not measured.
const Json* find_row(const Json& result, const std::string& method, int depth);

/// Whether the quantity can be compared with 1999's: trees always, rays at full size, seconds and
/// the stand-in never.
bool comparable(const std::string& scene, const std::string& quantity, bool full);

}  // namespace probebake::study
