// How wrong the spherical harmonics of a cubemap are, from the pixels that its audit drew.
//
// With p a drawn pixel, q its probability, w its solid angle, a its value and r = (r1 + r2) / 2 an
// estimate of its truth, w Y_lm(p) (a − r) / q has the expectation ΔL_lm = Σ w Y_lm (a − truth):
// the mean over the draws estimates the 27 differences (9 coefficients of R, G, B) without bias,
// their covariance comes from the sample. The truth is that of the cubemap's own grid.
#pragma once

#include <span>

#include "image/sh_projection.h"
#include "math/norm_estimate.h"

namespace probebake {

/// A drawn pixel and (a − r) / q.
struct ShDraw {
    CubePixel pixel;
    Vec3 difference{0.0};
};

struct ShAudit {
    uint64_t draws = 0;
    ShRgb difference{};                    // estimated ΔL: positive where the file is too bright
    ShRgb standard_error{};                // of the estimate
    NormEstimate irradiance;               // ‖A_l ΔL_lm‖ over 9 coefficients × RGB
    std::array<NormEstimate, 3> channels;  // ‖ΔL‖₂ of R, G and B
};

/// What may lie unseen where no draw found anything: the brightest radiance (root mean square over
/// the channels), and the rays that would have told of it.
struct Unseen {
    double radiance = 0.0;
    uint64_t told = 0;
};

/// At least two draws.
ShAudit audit_sh(std::span<const ShDraw> draws, int face_size_px, const Unseen& unseen = {});

/// irradiance_rel: the error over the length of what is in the file. Infinite where all of that is
/// black, and the truth is not or need not be.
NormEstimate relative_irradiance(const ShAudit& audit, const ShRgb& radiance);

}  // namespace probebake
