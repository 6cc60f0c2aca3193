// What is predicted of a pixel's squared error by what its rays have shown so far.
//
// The hybrid renderer refines in stages (hybrid.h). After each stage the error that is left is
// predicted as a sum of non-negative terms, each a variance in units of radiance² (mean over R, G,
// B):
//
//   contrast         mean squared difference to the first rays of the neighbouring pixels
//   child_variance   of the colours of the shown nodes' children: what their means hide
//   passed_contrast  mean squared difference to the nodes that the level of detail would have
//                    stopped at: large where rays slip past something into what is behind it
//   ray_variance[s]  of all rays up to stage s ≥ 1
//   hidden           mean squared difference within the pixel that rays beside its own have shown
//                    (HybridCubemap::reveal): contrast and ray_variance are no less
//   node_error       visibility error E_N of those nodes (node_error.h), a factor
//
// The coefficients were fitted on worlds named in docs/results/beyond.md, by maximum likelihood of
// an exponential error, and judged on others. A prediction orders pixels; it promises nothing: that
// is what audits are for.
#pragma once

#include <array>

namespace probebake {

inline constexpr int kHybridStages = 5;

/// What is known of a pixel after `stage`.
struct PixelEvidence {
    double contrast = 0.0;
    double hidden = 0.0;
    /// Of stages 0 and 1, means over their rays.
    std::array<double, 2> node_error{};
    std::array<double, 2> child_variance{};
    std::array<double, 2> passed_contrast{};
    std::array<double, kHybridStages> ray_variance{};
};

/// Terms of the prediction after a stage; those that a stage does not use are 0.
inline constexpr int kErrorTerms = 5;
std::array<double, kErrorTerms> error_terms(int stage, const PixelEvidence& evidence);

/// The coefficients of the terms, by stage. After the last stage nothing is predicted.
using ErrorModel = std::array<std::array<double, kErrorTerms>, kHybridStages - 1>;
extern const ErrorModel kErrorModel;

/// Predicted squared error after a stage; 0 after the last.
double predicted_error(int stage, const PixelEvidence& evidence,
                       const ErrorModel& model = kErrorModel);

}  // namespace probebake
