#include "math/shared_exponent.h"

#include <algorithm>

namespace probebake {

PackedRgb pack_rgb(const Rgb& rgb) {
    const float largest = std::max({rgb.r, rgb.g, rgb.b});
    if (!(largest > 0.0f)) return 0;
    int exponent = std::max(-16, std::ilogb(largest)) + 16;
    float unit = std::ldexp(1.0f, exponent - 24);
    if (std::floor(largest / unit + 0.5f) > 511.0f) {
        ++exponent;
        unit *= 2.0f;
    }
    const auto mantissa = [unit](float x) {
        return static_cast<uint32_t>(std::floor(std::max(x, 0.0f) / unit + 0.5f));
    };
    return mantissa(rgb.r) | (mantissa(rgb.g) << 9) | (mantissa(rgb.b) << 18) |
           (static_cast<uint32_t>(exponent) << 27);
}

}  // namespace probebake
