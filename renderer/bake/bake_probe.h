// One work unit: one probe in one lighting state, rendered, audited and encoded.
//
// bake_probe is a pure function of its arguments: the same bytes from any thread, process or
// machine of the class. It is rendered, audited, and refined and audited again on fresh pixels
// until the upper bound of its error meets the target. The audit of the last look is the
// certificate. The bound is
//   that of this audit alone, where it is large enough to tell: look k bounds with a confidence of
//   1 − (1 − c) · 2^−k, c being the job's, so that all looks together are wrong as often as c
//   allows, however often one looks (Bonferroni);
//   else the one of error_prior.h, which knows all audits of the probe and of others of the job.
#pragma once

#include "bake/pilot.h"
#include "bake/probe_result.h"

namespace probebake {

/// What the engine decides for a unit.
struct UnitParams {
    size_t probe = 0;
    /// The job's wall time is used up: the cheapest settings, no second look.
    bool out_of_time = false;
    /// Of all threads together, that it may take; kept by what looks at the clock: paths.
    std::optional<double> seconds;
    /// Whether further probes learn from this one's audit, which then is a larger one.
    bool teaches = false;
};

/// Throws Cancelled.
ProbeResult bake_probe(const Scene& scene, const JobSpec& job, const Pilot& pilot,
                       const UnitParams& unit, const CancelToken& cancel);

}  // namespace probebake
