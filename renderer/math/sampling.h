// Point sets in the unit square.
#pragma once

#include <cstdint>

#include "math/vec.h"

namespace probebake {

/// Sample `index` of a correlated multi-jittered set of columns × rows points (Kensler 2013,
/// "Correlated Multi-Jittered Sampling"): one point in every cell of the columns × rows grid, and
/// one in every of the columns·rows strips of each axis. `pattern` selects the permutations.
Vec2 correlated_multi_jitter(uint32_t index, uint32_t columns, uint32_t rows, uint32_t pattern);

}  // namespace probebake
