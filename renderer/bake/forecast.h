// What a job will take, before it is baked: seconds, memory, bytes of files.
//
// A few of its probes are piloted and baked, with faces of at most 64 pixels, and what they took is
// scaled to the whole job by its pixels. Lit states are taken for unlit ones, so that nothing has
// to be lit: what lighting takes is counted from the exposed faces and the shadow rays that each
// gets. Through media no more paths are traced than some seconds take; where a target takes more,
// the error that is left tells how many. Seconds depend on what else the machine does meanwhile;
// docs/results/calibration.md has figures.
#pragma once

#include "bake/plan.h"
#include "light/sky_file.h"

namespace probebake {

struct Forecast {
    double seconds = 0.0;  // of wall time, from the loaded scene to the report
    double lighting_seconds = 0.0;
    bool extrapolated = false;  // more paths are needed than were tried
    uint64_t memory_bytes = 0;  // at the peak of a process of its own
    uint64_t output_bytes = 0;  // of files
};

/// Runs on the calling arena, which has `threads`. Throws Cancelled.
Forecast make_forecast(const Scene& scene, const JobSpec& job, const Plan& plan, int threads,
                       const CancelToken& cancel, const SkySource& skies = read_sky_file);

Json write_forecast(const Forecast& forecast);

}  // namespace probebake
