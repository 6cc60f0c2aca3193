// One job of the calibration study: baked, and every probe held against the truth.
#pragma once

#include <optional>

#include "io/json.h"
#include "scene/scene.h"

namespace probebake::study {

struct CalibratedJob {
    int face_size_px = 16;
    int probes = 16;
    std::optional<int> probes_per_job;  // none: all of them in one
    bool lit = false;
    double psnr_db = 35.0;
};

/// What the job, or all of them together, came to: `rows`, one per probe (verdict, true and audited
/// errors, steps), and the steps of the pilot and of the cheapest single price. Parallel on the
/// calling arena.
Json calibrate_job(const Scene& scene, const CalibratedJob& what);

}  // namespace probebake::study
