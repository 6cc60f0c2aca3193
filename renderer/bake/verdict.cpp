#include "bake/verdict.h"

#include <array>

#include "render/hybrid.h"

namespace probebake {
namespace {

/// Whether the targets are met where the mean of all probes may tell of those that have no prior.
bool job_tells(const JobSpec& job, const ProbeResult& result, const MeasuredError& pooled) {
    const MeasuredError& own = result.certificate.error;
    return targets_meet(job.quality, [&](const QualityTarget& target) {
        const auto t = static_cast<size_t>(&target - job.quality.targets.data());
        if (t < result.met_by.size() && result.met_by[t] != EvidenceOf::kNone) return true;
        const bool has_prior = t < result.first_look.size() && result.first_look[t].has_value();
        return !has_prior && (own.mse.samples == 0 || estimate_meets(target, own)) &&
               bound_meets(target, pooled, job.quality.evidence.confidence);
    });
}

}  // namespace

std::string_view name_of(Verdict verdict) {
    constexpr std::array<std::string_view, 5> kNames = {
        "target_met", "target_missed", "budget_exhausted", "unreachable", "not_audited"};
    return kNames[static_cast<size_t>(verdict)];
}

Judgement judge(const JobSpec& job, const Pilot& pilot, const ProbeResult& result,
                const MeasuredError& pooled) {
    // A number of rays is a limit that holds by construction.
    if (only_target(job.quality, QualityTarget::Metric::kRays)) {
        return {Verdict::kTargetMet, EvidenceOf::kNone};
    }
    if (!result.audited() && pooled.mse.samples == 0) {
        return {Verdict::kNotAudited, EvidenceOf::kNone};
    }
    if (result.target_met) return {Verdict::kTargetMet, result.evidence};
    if (job_tells(job, result, pooled)) return {Verdict::kTargetMet, EvidenceOf::kJob};
    const EvidenceOf of = result.certificate.pixels > 0 ? EvidenceOf::kProbe : EvidenceOf::kJob;
    if (result.limited || pilot.expectation == Expectation::kBudgetExhausted) {
        return {Verdict::kBudgetExhausted, of};
    }
    const bool finest = pilot.finer.empty() || result.settings == pilot.finer.back().settings ||
                        casts_all_leaf_rays(result.settings);  // steered probes end there
    if (pilot.expectation == Expectation::kUnreachable || (finest && !job.quality.settings)) {
        return {Verdict::kUnreachable, of};
    }
    return {Verdict::kTargetMissed, of};
}

}  // namespace probebake
