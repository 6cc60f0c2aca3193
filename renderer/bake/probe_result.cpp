#include "bake/probe_result.h"

#include <cmath>

namespace probebake {

std::string_view name_of(EvidenceOf evidence) {
    constexpr std::array<std::string_view, 3> kNames = {"none", "probe", "job"};
    return kNames[static_cast<size_t>(evidence)];
}

ErrorFigures error_figures(const QualitySpec& quality, const ProbeResult& result) {
    for (size_t t = 0; t < result.pooled.size(); ++t) {
        const bool of_squares = quality.targets[t].metric == QualityTarget::Metric::kPsnrDb ||
                                quality.targets[t].metric == QualityTarget::Metric::kRmse;
        if (!of_squares || !result.pooled[t]) continue;
        const PooledError& pooled = *result.pooled[t];
        const auto db = [](double mse) { return -10.0 * std::log10(mse); };
        return {.rmse = std::sqrt(pooled.value),
                .rmse_interval = {std::sqrt(pooled.interval.low), std::sqrt(pooled.interval.high)},
                .psnr_db = db(pooled.value),
                .psnr_low_db = db(pooled.interval.high),
                .psnr_high_db = db(pooled.interval.low)};
    }
    return figures_of(result.certificate.error.mse, result.confidence);
}

CostStats ProbeResult::render_cost() const {
    CostStats total;
    for (const CostStats& face : faces) total += face;
    return total;
}

}  // namespace probebake
