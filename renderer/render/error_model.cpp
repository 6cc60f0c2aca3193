#include "render/error_model.h"

#include <algorithm>

namespace probebake {

const ErrorModel kErrorModel = {{
    {0.336, 0.0, 0.0790, 0.0200, 0.0},
    {0.0472, 0.0433, 0.0, 0.0363, 0.0168},
    {0.00132, 0.00488, 0.0185, 0.0, 0.0},
    {0.000163, 0.000003, 0.00462, 0.0, 0.0},
}};

std::array<double, kErrorTerms> error_terms(int stage, const PixelEvidence& e) {
    const auto visible = [](double node_error) { return std::max(0.0, node_error); };
    const double contrast = std::max(e.contrast, e.hidden);
    const auto variance = [&](size_t s) { return std::max(e.ray_variance[s], e.hidden); };
    switch (stage) {
        case 0:
            return {contrast, contrast * visible(e.node_error[0]), e.child_variance[0],
                    e.passed_contrast[0], 0.0};
        case 1:
            return {contrast, variance(1), variance(1) * visible(e.node_error[1]),
                    e.child_variance[1], e.passed_contrast[1]};
        case 2:
            return {contrast, e.passed_contrast[1], variance(2), 0.0, 0.0};
        case 3:
            return {e.passed_contrast[1], variance(2), variance(3), 0.0, 0.0};
        default:
            return {};
    }
}

double predicted_error(int stage, const PixelEvidence& evidence, const ErrorModel& model) {
    if (stage >= kHybridStages - 1) return 0.0;
    const std::array<double, kErrorTerms> terms = error_terms(stage, evidence);
    const std::array<double, kErrorTerms>& coefficients = model[static_cast<size_t>(stage)];
    double sum = 0.0;
    for (size_t i = 0; i < kErrorTerms; ++i) sum += coefficients[i] * terms[i];
    return sum;
}

}  // namespace probebake
