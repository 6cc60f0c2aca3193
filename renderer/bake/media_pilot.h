// The pilot of a lighting state that is seen through media (pilot.h, media_state.h).
//
//   choose octree depth and tracker on rays of the job's probes
//   -> choose pixels, trace paths in each -> exposure, spread -> the noise that the render aims at
//   -> the same pixels with 1, 4, 16, … paths each: the curve of error against cost
//
// A pixel's paths have a variance, which says what any number of them leaves: no settings are
// compared. Pixels of the curve have equal numbers of paths; those of a render have what the
// variance asks for, which costs less.
#pragma once

#include "bake/pilot.h"

namespace probebake {

/// Throws Cancelled.
Pilot run_media_pilot(const Scene& scene, const JobSpec& job, const ReadyState& state,
                      const CancelToken& cancel, const std::optional<TimeBudget>& time);

}  // namespace probebake
