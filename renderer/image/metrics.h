// How far an image is from its reference; both are divided by the exposure first.
//
// RMSE over pixels and channels; PSNR with peak 1; SSIM of luminance (ssim.h), not defined below 11
// pixels; rel_mse = mean((a − r)² / (r² + 0.01 mean(r)²)) over pixels and channels, mean(r) being
// that of the whole image or cube. A cube's figures are means over its stored pixels: the mean
// squared error is the mean of the faces', SSIM is the mean of the faces' SSIM. Uniform weights
// count an edge pixel once for every face that stores it; solid-angle weights clip its cell at
// the edge of each face, so that directions count once; a window of SSIM weighs what its central
// pixel does. Sums are in double. Source: docs/conventions.md, "Image metrics".
#pragma once

#include <array>
#include <optional>

#include "image/cubemap.h"

namespace probebake {

struct ImageError {
    double rmse = 0.0;
    std::optional<double> psnr_db;  // none where exact
    std::optional<double> ssim;     // none below 11 pixels
    std::optional<double> rel_mse;  // none where only the reference is black
    bool exact = true;              // no pixel differs
};

struct CubeError {
    std::array<ImageError, kFaceCount> faces;
    ImageError cube;
};

enum class Weighting { kUniform, kSolidAngle };

/// Throws std::invalid_argument where the sizes differ or the exposure is not positive. A NaN in an
/// image makes every figure NaN that it goes into.
ImageError compare_images(const Image& image, const Image& reference, double exposure);
CubeError compare_cubemaps(const Cubemap& cubemap, const Cubemap& reference, double exposure,
                           Weighting weighting = Weighting::kUniform);

}  // namespace probebake
