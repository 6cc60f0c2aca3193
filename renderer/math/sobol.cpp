#include "math/sobol.h"

#include "math/random.h"

namespace probebake {
namespace {

constexpr int kBits = 32;
using Matrix = std::array<uint32_t, kBits>;

/// Direction numbers of x^degree + … + 1, whose middle coefficients are the bits of `middle`, from
/// the first numbers m (Joe and Kuo 2008, new-joe-kuo-6).
constexpr Matrix direction_numbers(int degree, uint32_t middle, const std::array<uint32_t, 3>& m) {
    Matrix v{};
    for (int i = 0; i < kBits; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (i < degree) {
            v[at] = m[at] << (31 - i);
            continue;
        }
        const uint32_t before = v[static_cast<std::size_t>(i - degree)];
        v[at] = before ^ (before >> degree);
        for (int k = 1; k < degree; ++k) {
            if ((middle >> (degree - 1 - k) & 1u) != 0) v[at] ^= v[static_cast<std::size_t>(i - k)];
        }
    }
    return v;
}

constexpr Matrix van_der_corput() {
    Matrix v{};
    for (int i = 0; i < kBits; ++i) v[static_cast<std::size_t>(i)] = 1u << (31 - i);
    return v;
}

constexpr std::array<Matrix, kSobolDimensions> kMatrices = {
    van_der_corput(), direction_numbers(1, 0, {1}), direction_numbers(2, 1, {1, 3}),
    direction_numbers(3, 1, {1, 3, 1})};

uint32_t reverse(uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0x00FF00FFu) << 8) | ((x & 0xFF00FF00u) >> 8);
    x = ((x & 0x0F0F0F0Fu) << 4) | ((x & 0xF0F0F0F0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xCCCCCCCCu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xAAAAAAAAu) >> 1);
}

/// Flips every bit by a hash of those above it (Laine and Karras 2011, constants of Burley 2020).
uint32_t owen_scramble(uint32_t x, uint32_t seed) {
    x = reverse(x);
    x ^= x * 0x3D20ADEAu;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526C56u;
    x ^= x * 0x53A22864u;
    return reverse(x);
}

}  // namespace

std::array<double, kSobolDimensions> sobol_point(uint32_t index, uint32_t seed) {
    std::array<double, kSobolDimensions> point{};
    for (std::size_t d = 0; d < kSobolDimensions; ++d) {
        uint32_t x = 0;
        for (std::size_t i = 0; i < kBits; ++i) {
            if ((index >> i & 1u) != 0) x ^= kMatrices[d][i];
        }
        const auto own = static_cast<uint32_t>(mix64(uint64_t{seed} << 8 | d));
        point[d] = owen_scramble(x, own) * 0x1.0p-32;
    }
    return point;
}

}  // namespace probebake
