#include "bake/ssim_noise.h"

#include "image/ssim.h"
#include "math/estimate.h"

namespace probebake {

double expected_ssim_loss(const Cubemap& as_written, std::span<const PixelAux> aux,
                          double exposure) {
    const int n = as_written.face_size();
    const size_t pixels = static_cast<size_t>(n) * static_cast<size_t>(n);
    Moments lost;
    for (size_t first = 0; first < aux.size(); first += pixels) {
        LuminancePlane image{n, n, {}};
        LuminancePlane variance{n, n, {}};
        for (size_t i = first; i < first + pixels; ++i) {
            const double value = ssim_luminance(as_written.at(pixel_at(i, n)), exposure);
            const double error = ssim_luminance(aux[i].standard_error, exposure);
            image.values.push_back(value);
            variance.values.push_back(value < 1.0 ? error * error : 0.0);
        }
        for (const double window : ssim_lost_to_noise(image, variance)) lost.add(window);
    }
    return lost.mean();
}

}  // namespace probebake
