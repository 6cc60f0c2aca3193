// The first four dimensions of Sobol's sequence, scrambled as Owen does, by hashes (Burley 2020,
// "Practical Hash-based Owen Scrambling"): every run of 2^k points from a multiple of 2^k on is a
// (0, k, 2)-net in the first two dimensions, and every dimension alone is stratified.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace probebake {

inline constexpr int kSobolDimensions = 4;

/// Point `index` in [0, 1)^4 of the sequence that `seed` names.
std::array<double, kSobolDimensions> sobol_point(uint32_t index, uint32_t seed);

}  // namespace probebake
