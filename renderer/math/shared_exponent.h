// Linear RGB in 32 bits: three 9-bit mantissas and one 5-bit exponent (the layout of
// EXT_texture_shared_exponent / VK E5B9G9R9): red in bits 0-8, green 9-17, blue 18-26, exponent
// 27-31, bias 15. Largest value 65,408; error at most 2^-9 of the largest component.
#pragma once

#include <cmath>
#include <cstdint>

#include "math/vec.h"

namespace probebake {

/// A packed colour; 0 is black. Wider ranges divide by a power of two first (ColorPyramid::scale).
using PackedRgb = uint32_t;

inline constexpr float kPackedRgbMax = 65408.0f;

/// Packs finite, non-negative RGB of at most kPackedRgbMax, rounding to nearest.
PackedRgb pack_rgb(const Rgb& rgb);

inline Rgb unpack_rgb(PackedRgb packed) {
    const float unit = std::ldexp(1.0f, static_cast<int>(packed >> 27) - 24);
    return {static_cast<float>(packed & 511u) * unit,
            static_cast<float>((packed >> 9) & 511u) * unit,
            static_cast<float>((packed >> 18) & 511u) * unit};
}

}  // namespace probebake
