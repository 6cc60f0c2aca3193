#include "bake/render_noise.h"

#include <algorithm>
#include <cmath>

#include "image/ssim.h"

namespace probebake {
namespace {

/// Of the irradiance error that a probe's pixels lead to expect, what it may be without being
/// unlucky.
constexpr double kUnlucky = 3.0;
/// What noise may take from SSIM at most and still be told from more of it.
constexpr double kMostSsimLost = 0.98;

}  // namespace

IrradianceNoise RenderNoise::irradiance() const {
    if (mse_) {
        const auto error = static_cast<float>(std::sqrt(*mse_) * pilot_.exposure);
        const std::vector<PixelAux> alike(render_.aux.size(), {.standard_error = Rgb(error)});
        return irradiance_noise(as_written_, alike);
    }
    IrradianceNoise noise = irradiance_noise(as_written_, render_.aux);
    const auto paths = static_cast<double>(render_.total().rays);
    const double both = (noise.square + pilot_.irradiance_square_times_paths / paths) / 2.0;
    if (noise.square > 0.0) noise.channels *= both / noise.square;
    noise.square = both;
    return noise;
}

double RenderNoise::ssim_lost() const {
    const int n = as_written_.face_size();
    const size_t pixels = static_cast<size_t>(n) * static_cast<size_t>(n);
    Moments lost;
    for (size_t first = 0; first < render_.aux.size(); first += pixels) {
        LuminancePlane image{n, n, {}};
        LuminancePlane variance{n, n, {}};
        for (size_t i = first; i < first + pixels; ++i) {
            const double value = ssim_luminance(as_written_.at(pixel_at(i, n)), pilot_.exposure);
            const double error = ssim_luminance(render_.aux[i].standard_error, pilot_.exposure);
            image.values.push_back(value);
            variance.values.push_back(value < 1.0 ? error * error : 0.0);
        }
        for (const double window : ssim_lost_to_noise(image, variance)) lost.add(window);
    }
    return lost.mean();
}

double RenderNoise::step(const QualityTarget& target, const Steering& steering) const {
    if (target.metric == QualityTarget::Metric::kIrradianceRel) {
        return *largest_size(target) / (kUnlucky * steering.prior.ratio * irradiance().square);
    }
    // SSIM loses v / (v + contrast) to a variance v.
    const auto variance = [](double lost) { return lost / (1.0 - lost); };
    return variance(std::min(steering.goal, kMostSsimLost)) /
           variance(std::min(ssim_lost(), kMostSsimLost));
}

}  // namespace probebake
