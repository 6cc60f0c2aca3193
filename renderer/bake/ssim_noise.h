// What the noise of single pixels takes from the SSIM of a cubemap.
#pragma once

#include <span>

#include "image/cubemap.h"
#include "render/render.h"

namespace probebake {

/// 1 − SSIM, mean over all windows of all faces, as the pixels' standard errors lead to expect
/// (ssim_lost_to_noise), their channels taken to err together; luminances beyond white do not err.
/// 0 below faces of 11 pixels.
double expected_ssim_loss(const Cubemap& as_written, std::span<const PixelAux> aux,
                          double exposure);

}  // namespace probebake
