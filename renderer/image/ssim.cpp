#include "image/ssim.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

namespace probebake {
namespace {

constexpr size_t kSize = kSsimWindow_px;
constexpr double kSigma_px = 1.5;
constexpr double kC1 = 0.01 * 0.01;
constexpr double kC2 = 0.03 * 0.03;

/// The window is the outer product of these, which sum to 1.
std::array<double, kSize> make_weights() {
    std::array<double, kSize> weights{};
    double sum = 0.0;
    constexpr double kCentre = (kSsimWindow_px - 1) / 2.0;
    for (size_t i = 0; i < kSize; ++i) {
        const double x = static_cast<double>(i) - kCentre;
        weights[i] = std::exp(-0.5 * x * x / (kSigma_px * kSigma_px));
        sum += weights[i];
    }
    for (double& w : weights) w /= sum;
    return weights;
}
const std::array<double, kSize>& weights() {
    static const std::array<double, kSize> kWeights = make_weights();
    return kWeights;
}

/// Sum of the squares of a window's weights.
double squared_weights() {
    double row = 0.0;
    for (const double w : weights()) row += w * w;
    return row * row;
}

/// Weighted mean over a window of a function of the pixel's index.
template <class Function>
double window_mean(const Function& value) {
    double sum = 0.0;
    for (size_t y = 0; y < kSize; ++y) {
        double row = 0.0;
        for (size_t x = 0; x < kSize; ++x) row += weights()[x] * value(y * kSize + x);
        sum += weights()[y] * row;
    }
    return sum;
}

/// Moments of a window of the image and of the reference.
struct Moments {
    double mean_a, mean_r;
    double mean_aa, mean_rr, mean_ar;  // of the products
};

double ssim_of(const Moments& m) {
    const double aa = m.mean_a * m.mean_a;
    const double rr = m.mean_r * m.mean_r;
    const double ar = m.mean_a * m.mean_r;
    return (2.0 * ar + kC1) * (2.0 * (m.mean_ar - ar) + kC2) /
           ((aa + rr + kC1) * ((m.mean_aa - aa) + (m.mean_rr - rr) + kC2));
}

using Values = std::vector<double>;

/// Weighted means along x, then along y, wherever the window fits.
Values filter(const Values& values, size_t width, size_t height) {
    const size_t out_width = width - kSize + 1;
    const size_t out_height = height - kSize + 1;
    Values rows(out_width * height);
    for (size_t y = 0; y < height; ++y) {
        for (size_t x = 0; x < out_width; ++x) {
            double sum = 0.0;
            for (size_t i = 0; i < kSize; ++i) sum += weights()[i] * values[y * width + x + i];
            rows[y * out_width + x] = sum;
        }
    }
    Values out(out_width * out_height);
    for (size_t y = 0; y < out_height; ++y) {
        for (size_t i = 0; i < kSize; ++i) {
            for (size_t x = 0; x < out_width; ++x) {
                out[y * out_width + x] += weights()[i] * rows[(y + i) * out_width + x];
            }
        }
    }
    return out;
}

Values product(const Values& a, const Values& b) {
    Values out(a.size());
    std::transform(a.begin(), a.end(), b.begin(), out.begin(), std::multiplies<>());
    return out;
}

}  // namespace

double ssim_luminance(const Rgb& color, double exposure) {
    const double value = 0.2126 * static_cast<double>(color.r) +
                         0.7152 * static_cast<double>(color.g) +
                         0.0722 * static_cast<double>(color.b);
    return std::clamp(value / exposure, 0.0, 1.0);
}

LuminancePlane ssim_plane(std::span<const Rgb> pixels, int width, double exposure) {
    LuminancePlane plane{width, width > 0 ? static_cast<int>(pixels.size()) / width : 0, {}};
    plane.values.reserve(pixels.size());
    for (const Rgb& c : pixels) plane.values.push_back(ssim_luminance(c, exposure));
    return plane;
}

SsimWindow ssim_window(const LuminancePlane& plane, int x, int y) {
    if (x < 0 || y < 0 || x > plane.width - kSsimWindow_px || y > plane.height - kSsimWindow_px) {
        throw std::out_of_range("the window of SSIM at (" + std::to_string(x) + ", " +
                                std::to_string(y) + ") leaves the image");
    }
    SsimWindow window{};
    for (size_t row = 0; row < kSize; ++row) {
        const size_t first = (static_cast<size_t>(y) + row) * static_cast<size_t>(plane.width) +
                             static_cast<size_t>(x);
        std::copy_n(plane.values.begin() + static_cast<std::ptrdiff_t>(first), kSize,
                    window.begin() + static_cast<std::ptrdiff_t>(row * kSize));
    }
    return window;
}

double ssim(const SsimWindow& a, const SsimWindow& r) {
    return ssim_of({window_mean([&](size_t i) { return a[i]; }),
                    window_mean([&](size_t i) { return r[i]; }),
                    window_mean([&](size_t i) { return a[i] * a[i]; }),
                    window_mean([&](size_t i) { return r[i] * r[i]; }),
                    window_mean([&](size_t i) { return a[i] * r[i]; })});
}

// Let r_k = r + n_k with E n_k = 0, n_1 and n_2 independent of each other and of a; <·> is the
// weighted mean over the window. SSIM's terms are linear in <r>, <ar>, <r>² and <r²>, and
//   <(r1 + r2)/2> and <a (r1 + r2)/2>   have the means <r> and <ar>,
//   <r1><r2> and <r1 r2>                have the means <r>² and <r²>,
// whereas <(r1 + r2)/2>² and <((r1 + r2)/2)²> exceed them by the noise's variance. So all four
// factors of SSIM are estimated without bias. Their ratio is not: with D the contrast factor of
// the denominator and D + δ its estimate, E 1/(D + δ) ≈ (1 + Var δ / D²) / D, and where the noise
// rivals C2 the estimate passes through 0. Writing the reciprocal as D / (D² + v), with v an
// estimate of Var δ, cancels this term (its second derivative at v = 0 gives + v / D³, the change
// by v itself − v / D³) and bounds it. Without contrast δ = <n1 n2>, whose variance is s⁴ Σ w²;
// with contrast δ is small against D. What remains is the covariance of numerator and denominator,
// of second order too, and small in practice (tests/image/ssim_test.cpp). s² is the weighted
// variance of r1 − r2, halved.
double ssim(const SsimWindow& a, const SsimWindow& r1, const SsimWindow& r2) {
    const double mean_a = window_mean([&](size_t i) { return a[i]; });
    const double mean_1 = window_mean([&](size_t i) { return r1[i]; });
    const double mean_2 = window_mean([&](size_t i) { return r2[i]; });
    const double mean_r = (mean_1 + mean_2) / 2.0;
    const double variance_a = window_mean([&](size_t i) { return a[i] * a[i]; }) - mean_a * mean_a;
    const double variance_r =
        window_mean([&](size_t i) { return r1[i] * r2[i]; }) - mean_1 * mean_2;
    const double covariance =
        window_mean([&](size_t i) { return a[i] * (r1[i] + r2[i]) / 2.0; }) - mean_a * mean_r;

    const double difference = mean_1 - mean_2;
    const double noise_variance =
        (window_mean([&](size_t i) { return (r1[i] - r2[i]) * (r1[i] - r2[i]); }) -
         difference * difference) /
        2.0;
    const double v = noise_variance * noise_variance * squared_weights();

    const double brightness =
        (2.0 * mean_a * mean_r + kC1) / (mean_a * mean_a + mean_1 * mean_2 + kC1);
    const double contrast = variance_a + variance_r + kC2;
    return brightness * (2.0 * covariance + kC2) * contrast / (contrast * contrast + v);
}

std::vector<double> ssim_map(const LuminancePlane& a, const LuminancePlane& r) {
    if (a.width != r.width || a.height != r.height) {
        throw std::invalid_argument("SSIM compares images of one size");
    }
    if (a.width < kSsimWindow_px || a.height < kSsimWindow_px) return {};
    const auto filtered = [&](const Values& values) {
        return filter(values, static_cast<size_t>(a.width), static_cast<size_t>(a.height));
    };
    const Values mean_a = filtered(a.values);
    const Values mean_r = filtered(r.values);
    const Values mean_aa = filtered(product(a.values, a.values));
    const Values mean_rr = filtered(product(r.values, r.values));
    const Values mean_ar = filtered(product(a.values, r.values));
    std::vector<double> map;
    map.reserve(mean_a.size());
    for (size_t i = 0; i < mean_a.size(); ++i) {
        map.push_back(ssim_of({mean_a[i], mean_r[i], mean_aa[i], mean_rr[i], mean_ar[i]}));
    }
    return map;
}

// With V the weighted mean of the variances, an image of a truth of mean m and contrast c² has the
// expected contrast c² + V and the covariance c² with it, and its mean errs by a variance of about
// V Σ w²: both factors of SSIM follow.
std::vector<double> ssim_lost_to_noise(const LuminancePlane& image,
                                       const LuminancePlane& variance) {
    if (image.width != variance.width || image.height != variance.height) {
        throw std::invalid_argument("every pixel needs its variance");
    }
    if (image.width < kSsimWindow_px || image.height < kSsimWindow_px) return {};
    const auto filtered = [&](const Values& values) {
        return filter(values, static_cast<size_t>(image.width), static_cast<size_t>(image.height));
    };
    const Values mean = filtered(image.values);
    const Values mean_square = filtered(product(image.values, image.values));
    const Values noise = filtered(variance.values);
    std::vector<double> lost;
    lost.reserve(mean.size());
    for (size_t i = 0; i < mean.size(); ++i) {
        const double noise_of_mean = noise[i] * squared_weights();
        const double square = std::max(0.0, mean[i] * mean[i] - noise_of_mean);
        const double contrast = std::max(0.0, mean_square[i] - mean[i] * mean[i] - noise[i]);
        const double brightness = (2.0 * square + kC1) / (2.0 * square + noise_of_mean + kC1);
        const double structure = (2.0 * contrast + kC2) / (2.0 * contrast + noise[i] + kC2);
        lost.push_back(1.0 - brightness * structure);
    }
    return lost;
}

}  // namespace probebake
