// Point sets in the unit square, and in four dimensions.
#pragma once

#include <array>
#include <cstdint>

#include "math/vec.h"

namespace probebake {

/// Sample `index` of a correlated multi-jittered set of columns × rows points (Kensler 2013,
/// "Correlated Multi-Jittered Sampling"): one point in every cell of the columns × rows grid, and
/// one in every of the columns·rows strips of each axis. `pattern` selects the permutations.
Vec2 correlated_multi_jitter(uint32_t index, uint32_t columns, uint32_t rows, uint32_t pattern);

/// Point `index` of the Sobol' sequence in two dimensions, nested uniformly scrambled (Owen 1995;
/// by the hash of Laine and Karras 2011 as improved by Burley 2020). Of its first 4^k points every
/// one lies in its own cell of the 2^k × 2^k grid, and all points before it keep their places: a
/// set that grows.
Vec2 owen_sobol(uint32_t index, uint64_t key);

/// The same in four dimensions; the first two are those of owen_sobol, every one is stratified.
std::array<double, 4> owen_sobol_4d(uint32_t index, uint64_t key);

}  // namespace probebake
