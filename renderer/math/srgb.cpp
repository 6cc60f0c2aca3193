#include "math/srgb.h"

#include <array>
#include <cmath>

namespace probebake {

float srgb_to_linear(uint8_t encoded) {
    static const std::array<float, 256> kLinear = [] {
        std::array<float, 256> table{};
        for (size_t i = 0; i < table.size(); ++i) {
            const double x = static_cast<double>(i) / 255.0;
            table[i] =
                static_cast<float>(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
        }
        return table;
    }();
    return kLinear[encoded];
}

}  // namespace probebake
