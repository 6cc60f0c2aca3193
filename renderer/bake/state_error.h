// How wrong the probes of a lighting state are on average.
//
// The audits alone say too little: a probe is audited until it looks good, and what is wrong in few
// pixels is missed more often than found, so that their mean is too low. Where probes have a
// posterior (error_prior.h), the state's error is the mean of theirs.
#pragma once

#include "bake/report.h"

namespace probebake {

/// The last audits of all probes as one estimate: the mean over the probes.
MeasuredError pooled_error(const BakeRecord& record, const LightingState& state);

/// One per target, in its size (error_size); none where a target is not predicted.
std::vector<std::optional<PooledError>> state_errors(const BakeRecord& record, const Pilot& pilot);

}  // namespace probebake
