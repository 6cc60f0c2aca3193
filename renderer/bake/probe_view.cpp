#include "bake/probe_view.h"

namespace probebake {

std::vector<double> owned_pixel_weights(Weighting weighting, int n, double exposure) {
    const size_t count = 6 * static_cast<size_t>(n) * static_cast<size_t>(n);
    const double unit = 1.0 / (static_cast<double>(count) * exposure * exposure);
    std::vector<double> weights(count);
    for (size_t i = 0; i < count; ++i) {
        const CubePixel pixel = pixel_at(i, n);
        weights[cube_index(owner_of(pixel, n), n)] += unit * pixel_weight(weighting, pixel, n);
    }
    return weights;
}

}  // namespace probebake
