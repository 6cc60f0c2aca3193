// Fits the coefficients of the error model (render/error_model.h).
#pragma once

#include <span>
#include <vector>

#include "study/beyond/hybrid_set.h"

namespace probebake::study {

/// Squared errors y of pixels as exponential variables of mean p = Σ aᵢ termᵢ, aᵢ ≥ 0: maximises
/// Σ −(y / p + log p) by multiplicative updates (as in non-negative matrix factorisation with the
/// Itakura-Saito divergence; Févotte, Bertin, Durrieu 2009), every scene with the same weight.
/// Stages beyond the recorded ones keep the coefficients of `otherwise`.
ErrorModel fit_error_model(std::span<const std::vector<RecordedPixel>> scenes,
                           const ErrorModel& otherwise);

}  // namespace probebake::study
