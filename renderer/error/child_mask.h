// Which octants of a cube are filled: bit x + 2y + 4z, the lowest three bits of a Morton code
// (Müller 2020, 3.1). The tables of this folder hold one value for each of the 256 masks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "math/vec.h"

namespace probebake {

inline constexpr size_t kMaskCount = 256;

/// One value per child mask.
using MaskErrors = std::array<double, kMaskCount>;

/// The mask as a mirror shows it: axis a is reversed where bit a of `axes` is set.
constexpr uint8_t mirror_mask(uint8_t mask, unsigned axes) {
    unsigned m = mask;
    if ((axes & 1u) != 0) m = (m & 0x55u) << 1 | (m & 0xAAu) >> 1;
    if ((axes & 2u) != 0) m = (m & 0x33u) << 2 | (m & 0xCCu) >> 2;
    if ((axes & 4u) != 0) m = (m & 0x0Fu) << 4 | (m & 0xF0u) >> 4;
    return static_cast<uint8_t>(m);
}

/// Bit a is set where component a is negative: mirroring these axes turns d into the +++ octant.
inline unsigned negative_axes(const Vec3& d) {
    return (d.x < 0.0 ? 1u : 0u) | (d.y < 0.0 ? 2u : 0u) | (d.z < 0.0 ? 4u : 0u);
}

/// f(S) becomes the sum of f(T) over all subsets T of S, S included (zeta transform).
template <class T>
void sum_over_subsets(std::array<T, kMaskCount>& f) {
    for (size_t bit = 1; bit < kMaskCount; bit *= 2) {
        for (size_t set = 0; set < kMaskCount; ++set) {
            if ((set & bit) != 0) f[set] += f[set ^ bit];
        }
    }
}

}  // namespace probebake
