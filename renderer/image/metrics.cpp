#include "image/metrics.h"

#include <cmath>
#include <numeric>
#include <stdexcept>

#include "image/ssim.h"

namespace probebake {
namespace {

/// Pixels of an image and of its reference, and their weights, which repeat (one weight: uniform;
/// those of a face: a face or six).
struct Pair {
    std::span<const Rgb> image;
    std::span<const Rgb> reference;
    std::span<const double> weights;
    double exposure;

    double weight(size_t i) const { return weights[i % weights.size()]; }
};

constexpr double kChannelCount = 3.0;

/// Σ weight · value(image, reference) / Σ weight over pixels and channels.
template <class Function>
double weighted_mean(const Pair& pair, const Function& value) {
    double sum = 0.0;
    double weight_sum = 0.0;
    for (size_t i = 0; i < pair.image.size(); ++i) {
        double pixel = 0.0;
        for (int c = 0; c < 3; ++c) {
            pixel += value(static_cast<double>(pair.image[i][c]) / pair.exposure,
                           static_cast<double>(pair.reference[i][c]) / pair.exposure);
        }
        sum += pair.weight(i) * pixel;
        weight_sum += kChannelCount * pair.weight(i);
    }
    return sum / weight_sum;
}

/// Everything but SSIM.
ImageError pixel_error(const Pair& pair) {
    const double mse = weighted_mean(pair, [](double a, double r) { return (a - r) * (a - r); });
    ImageError error{.rmse = std::sqrt(mse), .rel_mse = 0.0, .exact = mse == 0.0};
    if (error.exact) return error;
    error.psnr_db = -10.0 * std::log10(mse);
    const double mean = weighted_mean(pair, [](double, double r) { return r; });
    const double floor = 0.01 * mean * mean;
    error.rel_mse.reset();
    if (mean != 0.0) {
        error.rel_mse = weighted_mean(
            pair, [floor](double a, double r) { return (a - r) * (a - r) / (r * r + floor); });
    }
    return error;
}

/// Mean SSIM of the windows, each weighted as its central pixel.
std::optional<double> mean_ssim(const Pair& pair, int width) {
    const LuminancePlane plane = ssim_plane(pair.image, width, pair.exposure);
    const auto map = ssim_map(plane, ssim_plane(pair.reference, width, pair.exposure));
    if (map.empty()) return std::nullopt;
    constexpr size_t kMargin = kSsimWindow_px / 2;
    const size_t map_width = static_cast<size_t>(width) - 2 * kMargin;
    double sum = 0.0;
    double weight_sum = 0.0;
    for (size_t i = 0; i < map.size(); ++i) {
        const size_t centre =
            (i / map_width + kMargin) * static_cast<size_t>(width) + i % map_width + kMargin;
        sum += pair.weight(centre) * map[i];
        weight_sum += pair.weight(centre);
    }
    return sum / weight_sum;
}

ImageError full_error(const Pair& pair, int width) {
    ImageError error = pixel_error(pair);
    error.ssim = mean_ssim(pair, width);
    return error;
}

void check(bool same_size, double exposure) {
    if (!same_size) throw std::invalid_argument("the images compared differ in size");
    if (!(exposure > 0.0) || !std::isfinite(exposure)) {
        throw std::invalid_argument("the exposure is " + std::to_string(exposure) +
                                    ", expected positive");
    }
}

std::vector<double> face_weights(Weighting weighting, int n) {
    if (weighting == Weighting::kUniform) return {1.0};
    std::vector<double> weights;
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) weights.push_back(pixel_solid_angle(x, y, n));
    }
    return weights;
}

}  // namespace

ImageError compare_images(const Image& image, const Image& reference, double exposure) {
    check(image.width() == reference.width() && image.height() == reference.height() &&
              !image.empty(),
          exposure);
    const std::array<double, 1> uniform = {1.0};
    return full_error({image.pixels(), reference.pixels(), uniform, exposure}, image.width());
}

CubeError compare_cubemaps(const Cubemap& cubemap, const Cubemap& reference, double exposure,
                           Weighting weighting) {
    const int n = cubemap.face_size();
    check(n == reference.face_size() && n > 0, exposure);
    const std::vector<double> weights = face_weights(weighting, n);
    const Pair whole{cubemap.image().pixels(), reference.image().pixels(), weights, exposure};
    const size_t face_pixels = static_cast<size_t>(n) * static_cast<size_t>(n);
    CubeError result;
    double ssim_sum = 0.0;
    for (size_t f = 0; f < kFaceCount; ++f) {
        result.faces[f] =
            full_error({whole.image.subspan(f * face_pixels, face_pixels),
                        whole.reference.subspan(f * face_pixels, face_pixels), weights, exposure},
                       n);
        ssim_sum += result.faces[f].ssim.value_or(0.0);
    }
    result.cube = pixel_error(whole);
    if (result.faces[0].ssim) result.cube.ssim = ssim_sum / kFaceCount;
    return result;
}

}  // namespace probebake
