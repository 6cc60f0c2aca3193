#include "math/sampling.h"

#include "math/random.h"

namespace probebake {
namespace {

/// A permutation of [0, length) chosen by `pattern`: a reversible hash on the next power of two,
/// walked until it lands inside (Kensler 2013, section 2).
uint32_t permute(uint32_t index, uint32_t length, uint32_t pattern) {
    uint32_t mask = length - 1;
    for (int shift = 1; shift <= 16; shift *= 2) mask |= mask >> shift;
    do {
        index ^= pattern;
        index *= 0xE170893Du;
        index ^= pattern >> 16;
        index ^= (index & mask) >> 4;
        index ^= pattern >> 8;
        index *= 0x0929EB3Fu;
        index ^= pattern >> 23;
        index ^= (index & mask) >> 1;
        index *= 1u | pattern >> 27;
        index *= 0x6935FA69u;
        index ^= (index & mask) >> 11;
        index *= 0x74DCB303u;
        index ^= (index & mask) >> 2;
        index *= 0x9E501CC3u;
        index ^= (index & mask) >> 2;
        index *= 0xC860A3DFu;
        index &= mask;
        index ^= index >> 5;
    } while (index >= length);
    return (index + pattern) % length;
}

}  // namespace

Vec2 correlated_multi_jitter(uint32_t index, uint32_t columns, uint32_t rows, uint32_t pattern) {
    const uint32_t column = index % columns;
    const uint32_t row = index / columns;
    const uint32_t shuffled_column = permute(column, columns, pattern * 0xA511E9B3u);
    const uint32_t shuffled_row = permute(row, rows, pattern * 0x63D83595u);
    RandomStream jitter(random_key({pattern, index}));
    const double m = columns;
    const double n = rows;
    return {(column + (shuffled_row + jitter.uniform()) / n) / m,
            (row + (shuffled_column + jitter.uniform()) / m) / n};
}

}  // namespace probebake
