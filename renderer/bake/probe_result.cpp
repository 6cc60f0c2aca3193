#include "bake/probe_result.h"

#include <cmath>

namespace probebake {

std::string_view name_of(EvidenceOf evidence) {
    constexpr std::array<std::string_view, 3> kNames = {"none", "probe", "job"};
    return kNames[static_cast<size_t>(evidence)];
}

ErrorFigures figures_of(const PooledError& square) {
    const Interval& interval = square.interval;
    return {.rmse = std::sqrt(square.value),
            .rmse_interval = {std::sqrt(interval.low), std::sqrt(interval.high)},
            .psnr_db = psnr_of(square.value),
            .psnr_low_db = psnr_of(interval.high),
            .psnr_high_db = psnr_of(interval.low)};
}

std::optional<ErrorFigures> error_figures(const QualitySpec& quality, const ProbeResult& result) {
    for (size_t t = 0; t < result.pooled.size(); ++t) {
        if (!is_of_squares(quality.targets[t].metric) || !result.pooled[t]) continue;
        return figures_of(*result.pooled[t]);
    }
    if (result.certificate.pixels == 0) return std::nullopt;
    return figures_of(result.certificate.error.mse, result.confidence);
}

CostStats ProbeResult::render_cost() const {
    CostStats total;
    for (const CostStats& face : faces) total += face;
    return total;
}

bool ProbeResult::audited() const {
    return certificate.pixels > 0 || std::any_of(pooled.begin(), pooled.end(),
                                                 [](const auto& told) { return told.has_value(); });
}

}  // namespace probebake
