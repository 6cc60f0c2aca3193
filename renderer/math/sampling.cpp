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

uint32_t reversed_bits(uint32_t x) {
    x = x >> 16 | x << 16;
    x = (x & 0x00FF00FFu) << 8 | (x & 0xFF00FF00u) >> 8;
    x = (x & 0x0F0F0F0Fu) << 4 | (x & 0xF0F0F0F0u) >> 4;
    x = (x & 0x33333333u) << 2 | (x & 0xCCCCCCCCu) >> 2;
    return (x & 0x55555555u) << 1 | (x & 0xAAAAAAAAu) >> 1;
}

/// Flips every bit as a hash of the more significant ones says. `reversed`: bits from the least.
uint32_t scrambled(uint32_t reversed, uint32_t seed) {
    reversed ^= reversed * 0x3D20ADEAu;
    reversed += seed;
    reversed *= (seed >> 16) | 1u;
    reversed ^= reversed * 0x05526C56u;
    reversed ^= reversed * 0x53A22864u;
    return reversed_bits(reversed);
}

/// The second dimension of Sobol's sequence, whose direction numbers are the rows of Pascal's
/// triangle modulo 2.
uint32_t sobol_second(uint32_t index) {
    uint32_t bits = 0;
    for (uint32_t direction = 1u << 31; index != 0; index >>= 1, direction ^= direction >> 1) {
        if ((index & 1u) != 0) bits ^= direction;
    }
    return bits;
}

using DirectionNumbers = std::array<uint32_t, 32>;

/// Of the primitive polynomial x^degree + … + 1, whose middle coefficients are the bits of
/// `middle`, from the first numbers m (Joe and Kuo 2008, new-joe-kuo-6).
constexpr DirectionNumbers direction_numbers(uint32_t degree, uint32_t middle,
                                             const std::array<uint32_t, 3>& m) {
    DirectionNumbers v{};
    for (uint32_t i = 0; i < 32; ++i) {
        if (i < degree) {
            v[i] = m[i] << (31 - i);
            continue;
        }
        v[i] = v[i - degree] ^ (v[i - degree] >> degree);
        for (uint32_t k = 1; k < degree; ++k) {
            if ((middle >> (degree - 1 - k) & 1u) != 0) v[i] ^= v[i - k];
        }
    }
    return v;
}
constexpr DirectionNumbers kThird = direction_numbers(2, 1, {1, 3});
constexpr DirectionNumbers kFourth = direction_numbers(3, 1, {1, 3, 1});

uint32_t sobol(uint32_t index, const DirectionNumbers& directions) {
    uint32_t bits = 0;
    for (size_t i = 0; index != 0; index >>= 1, ++i) {
        if ((index & 1u) != 0) bits ^= directions[i];
    }
    return bits;
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

Vec2 owen_sobol(uint32_t index, uint64_t key) {
    const auto seed_x = static_cast<uint32_t>(key);
    const auto seed_y = static_cast<uint32_t>(key >> 32);
    // The first dimension is the index with its bits reversed.
    return {scrambled(index, seed_x) * 0x1.0p-32,
            scrambled(reversed_bits(sobol_second(index)), seed_y) * 0x1.0p-32};
}

std::array<double, 4> owen_sobol_4d(uint32_t index, uint64_t key) {
    const Vec2 first = owen_sobol(index, key);
    const uint64_t other = mix64(key);
    const auto third = static_cast<uint32_t>(other);
    const auto fourth = static_cast<uint32_t>(other >> 32);
    return {first.x, first.y, scrambled(reversed_bits(sobol(index, kThird)), third) * 0x1.0p-32,
            scrambled(reversed_bits(sobol(index, kFourth)), fourth) * 0x1.0p-32};
}

}  // namespace probebake
