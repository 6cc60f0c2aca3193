#include "image/exposure.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace probebake {

double exposure_of(std::span<const Rgb> pixels) {
    if (pixels.empty()) throw std::invalid_argument("there is no exposure of no pixels");
    std::vector<float> luminances;
    luminances.reserve(pixels.size());
    for (const Rgb& c : pixels) {
        const float value = luminance(c);
        if (!std::isfinite(value)) throw std::domain_error("a pixel's luminance is not finite");
        luminances.push_back(value);
    }
    const size_t rank = (99 * luminances.size() + 99) / 100;
    const auto at = luminances.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::nth_element(luminances.begin(), at, luminances.end());
    return *at > 0.0f ? static_cast<double>(*at) : 1.0;
}

}  // namespace probebake
