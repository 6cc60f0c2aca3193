// What a job's first probes teach about the others.
#pragma once

#include <span>

#include "bake/pilot.h"
#include "bake/probe_result.h"

namespace probebake {

/// How many probes, from the first, are baked before the others so that these can learn from their
/// audits; 0 where it does not pay.
size_t probes_to_learn_from(const JobSpec& job);
inline bool learns(const JobSpec& job) { return probes_to_learn_from(job) > 0; }

/// What the first probes of a state have shown of how predictions and errors compare: for the
/// pilot that further probes are baked with.
void learn(Pilot& pilot, const QualitySpec& quality, std::span<const ProbeResult> first);

}  // namespace probebake
