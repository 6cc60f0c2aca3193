// The sRGB transfer function (IEC 61966-2-1).
#pragma once

#include <cstdint>

namespace probebake {

/// Linear value of an 8-bit sRGB one, 0 to 1.
float srgb_to_linear(uint8_t encoded);

}  // namespace probebake
