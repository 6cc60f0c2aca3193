// Structural similarity of luminance (Wang et al. 2004, "Image Quality Assessment").
//
// Luminance divided by the exposure and clipped to [0, 1]; Gaussian window of 11 × 11, sigma 1.5;
// weighted moments without Bessel's correction; K1 = 0.01, K2 = 0.03, L = 1; only windows that lie
// wholly in the image. Source: docs/conventions.md, "Image metrics".
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "math/vec.h"

namespace probebake {

inline constexpr int kSsimWindow_px = 11;

/// What SSIM sees of a pixel.
double ssim_luminance(const Rgb& color, double exposure);

/// Luminance as above, row by row.
struct LuminancePlane {
    int width = 0;
    int height = 0;
    std::vector<double> values;
};
LuminancePlane ssim_plane(std::span<const Rgb> pixels, int width, double exposure);

/// 11 × 11 luminances, row by row.
using SsimWindow = std::array<double, size_t{kSsimWindow_px} * kSsimWindow_px>;

/// The window whose top left pixel is (x, y), 0 ≤ x ≤ width − 11, 0 ≤ y ≤ height − 11.
SsimWindow ssim_window(const LuminancePlane& plane, int x, int y);

/// SSIM of a window against a reference without noise.
double ssim(const SsimWindow& a, const SsimWindow& reference);

/// SSIM of a window against two independent, unbiased, noisy references of the same truth, so that
/// their noise does not count as error. With noise of standard deviation s in each of them, the
/// bias stays below 0.005 up to s = 0.02 in a window without any contrast, and up to s = 0.1 where
/// the contrast exceeds the noise; beyond that it is pessimistic (a single estimate may exceed 1,
/// or fall below −1). Clipping is not undone: a mean that noise carries across 1 is seen too dark.
double ssim(const SsimWindow& a, const SsimWindow& reference1, const SsimWindow& reference2);

/// SSIM of every window of two planes of one size, row by row, (width − 10) × (height − 10) of
/// them; none below 11 pixels.
std::vector<double> ssim_map(const LuminancePlane& a, const LuminancePlane& reference);

/// What noise takes from the SSIM of every window of an image, in the order of ssim_map: 1 − SSIM
/// as it is to be expected of unbiased pixels that err independently with these variances.
std::vector<double> ssim_lost_to_noise(const LuminancePlane& image, const LuminancePlane& variance);

}  // namespace probebake
