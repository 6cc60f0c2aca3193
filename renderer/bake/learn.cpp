#include "bake/learn.h"

#include <algorithm>

namespace probebake {
namespace {

constexpr size_t kProbesToLearnFrom = 16;

}  // namespace

size_t probes_to_learn_from(const JobSpec& job) {
    return job.probes.size() >= 2 * kProbesToLearnFrom ? kProbesToLearnFrom : 0;
}

void learn(Pilot& pilot, const QualitySpec& quality, std::span<const ProbeResult> first) {
    for (const ProbeResult& result : first) {
        pilot.audit_cost += result.decision_cost;
        pilot.audit_cost += result.certificate.cost;
    }
    for (size_t t = 0; t < pilot.steering.size(); ++t) {
        if (!pilot.steering[t]) continue;
        std::vector<AuditedRatio> audits;
        for (const ProbeResult& result : first) {
            if (t < result.first_look.size() && result.first_look[t]) {
                audits.push_back(*result.first_look[t]);
            }
        }
        const ErrorPrior& before = pilot.steering[t]->prior;
        ErrorPrior prior = learned_prior(before, audits);
        // Of paths that carry much light and are rare, few pixels tell less than the pilot.
        if (quality.targets[t].metric == QualityTarget::Metric::kIrradianceRel) {
            prior.ratio = std::max(prior.ratio, before.ratio);
        }
        pilot.steering[t] = steering_of(quality.targets[t], prior);
        // Most have no windows of their own, and are to be met by what is known of the others.
        if (quality.targets[t].metric == QualityTarget::Metric::kSsim) {
            const double confidence = quality.evidence.confidence;
            pilot.steering[t]->goal = kNextAim * *largest_size(quality.targets[t]) /
                                      pooled_error(prior, {.predicted = 1.0}, confidence).upper;
        }
    }
}

}  // namespace probebake
