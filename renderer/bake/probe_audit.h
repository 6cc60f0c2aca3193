// One look at a probe as it is rendered now: what its audit draws, and what it may cost.
//
// An audit casts a share of its render's rays. Where a job's probes learn from each other and the
// renderer predicts their errors, no probe needs an audit that tells by itself: its audit draws
// what that share pays for, on average, which is nothing at all in most probes of a few pixels.
#pragma once

#include <limits>

#include "bake/audit.h"
#include "bake/rendered_probe.h"

namespace probebake {

/// Of a render's rays, what a usual audit of it casts.
inline constexpr double kAuditShare = 0.05;

struct Look {
    int number = 1;       // from 1 on: every look has random streams of its own
    double effort = 1.0;  // times the usual share of rays
    double most_rays = std::numeric_limits<double>::infinity();  // of the audit
    bool teaches = false;  // whether further probes learn from it
};

/// Runs on the calling arena. Throws Cancelled.
Audit audit_probe(const RenderedProbe& probe, const Look& look, const CancelToken& cancel);

/// Light that few rays of `render` tell of (hidden_light.h), before any audit; empty where there
/// can be none.
std::vector<double> light_to_reveal(const RenderedProbe& probe, CostStats& cost);

}  // namespace probebake
