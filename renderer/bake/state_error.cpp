#include "bake/state_error.h"

namespace probebake {
namespace {

/// Of a probe that its own audit tells of.
std::optional<PooledError> own_error(QualityTarget::Metric metric, const ProbeResult& result) {
    const std::optional<Estimate> size = error_size(metric, result.certificate.error);
    if (!size || !(size->value > 0.0)) return std::nullopt;
    return PooledError{.value = size->value, .spread = size->standard_error() / size->value};
}

}  // namespace

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
