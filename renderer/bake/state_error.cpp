#include "bake/state_error.h"

#include <algorithm>

namespace probebake {
namespace {

/// Of a probe that its own audit tells of.
std::optional<PooledError> own_error(QualityTarget::Metric metric, const ProbeResult& result) {
    const std::optional<Estimate> size = error_size(metric, result.certificate.error);
    if (!size || !(size->value > 0.0)) return std::nullopt;
    return PooledError{.value = size->value, .spread = size->standard_error() / size->value};
}

}  // namespace

MeasuredError pooled_error(const BakeRecord& record, const LightingState& state) {
    const auto audits_of_it = [&](const ProbeResult& result) {
        return result.state.id == state.id && result.certificate.pixels > 0;
    };
    const double weight = 1.0 / static_cast<double>(std::count_if(
                                    record.results.begin(), record.results.end(), audits_of_it));
    MeasuredError pooled;
    double windows = 0.0;  // probes that have any
    for (const ProbeResult& result : record.results) {
        if (!audits_of_it(result)) continue;
        const MeasuredError& error = result.certificate.error;
        pooled.mse.add(weight, error.mse);
        if (error.irradiance_square) {
            if (!pooled.irradiance_square) pooled.irradiance_square = Estimate{};
            pooled.irradiance_square->add(weight, *error.irradiance_square);
        } else if (error.irradiance) {
            if (!pooled.irradiance) pooled.irradiance = NormEstimate{};
            pooled.irradiance->add(weight, *error.irradiance);
        }
        if (error.rel_mse) {
            if (!pooled.rel_mse) pooled.rel_mse = Estimate{};
            pooled.rel_mse->add(weight, *error.rel_mse);
        }
        if (error.ssim) ++windows;
    }
    for (const ProbeResult& result : record.results) {
        const std::optional<Estimate>& ssim = result.certificate.error.ssim;
        if (!audits_of_it(result) || !ssim) continue;
        if (!pooled.ssim) pooled.ssim = Estimate{};
        pooled.ssim->add(1.0 / windows, *ssim);
    }
    return pooled;
}

std::vector<std::optional<PooledError>> state_errors(const BakeRecord& record, const Pilot& pilot) {
    const std::vector<QualityTarget>& targets = record.job.quality.targets;
    std::vector<std::optional<PooledError>> all(targets.size());
    for (size_t t = 0; t < pilot.steering.size(); ++t) {
        if (!pilot.steering[t]) continue;
        std::vector<PooledError> probes;
        for (const ProbeResult& result : record.results) {
            if (result.state.id != pilot.state.spec.id || t >= result.pooled.size()) continue;
            const auto known =
                result.pooled[t] ? result.pooled[t] : own_error(targets[t].metric, result);
            if (known) probes.push_back(*known);
        }
        if (probes.empty()) continue;
        all[t] = mean_error(probes, pilot.steering[t]->prior.common,
                            record.job.quality.evidence.confidence);
    }
    return all;
}

}  // namespace probebake
