// Whether a result is what was asked for, and whose evidence says so.
#pragma once

#include <string_view>

#include "bake/pilot.h"
#include "bake/probe_result.h"

namespace probebake {

enum class Verdict {
    kTargetMet,        // the far end of the error's interval meets the target
    kTargetMissed,     // it does not, though the settings were expected to
    kBudgetExhausted,  // the budget stood in the way
    kUnreachable,      // not even the finest settings meet it
    kNotAudited,       // no evidence was asked for
};
std::string_view name_of(Verdict verdict);

struct Judgement {
    Verdict verdict = Verdict::kNotAudited;
    EvidenceOf evidence = EvidenceOf::kNone;
};

/// By the probe's own evidence, then by the job's; `pooled` is the mean of the state's audits.
Judgement judge(const JobSpec& job, const Pilot& pilot, const ProbeResult& result,
                const MeasuredError& pooled);

}  // namespace probebake
