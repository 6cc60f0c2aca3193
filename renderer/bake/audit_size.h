// How much an audit draws, where that is not a matter of pixels alone.
#pragma once

#include "bake/job_spec.h"
#include "bake/quality.h"

namespace probebake {

/// Audited pixels for irradiance, which needs many: as asked for, else as many as these rays pay
/// for, at least 64 (8 where the mean of a job's probes tells) and a hundredth of the texels, at
/// most all of them.
int irradiance_draws(const JobSpec& job, int truth_grid, int face_size_px, double rays);

/// Windows of SSIM, and the rays per side of each of the two means of their pixels.
struct WindowDraws {
    int count = 0;
    int grid = kTruthGrids.front();
};

struct WindowParams {
    double rays_per_pixel = 1.0;           // of the render
    int truth_grid = kTruthGrids.front();  // most rays per side of a mean
    int least_grid = 2;                    // fewest
    bool of_many = false;                  // whether the mean of the job's probes tells as well
    bool pooled = false;                   // whether what each of the others has does, too
    bool teaches = false;                  // whether the others learn from this one
    uint64_t key = 0;                      // of the draw whether a pair is spared
};

/// Rays per side are 0.6 of the root of a pixel's, fewer than in single pixels (audit.h): windows
/// average over their noise. As many windows as these rays pay for, at least 16, or 2 in jobs of
/// many probes; where they are pooled as many as the rays pay for on average, in pairs:
/// none in most probes of small faces.
WindowDraws ssim_windows(const WindowParams& params, double rays);

/// So many draws on average, in pairs: a single one does not tell how far it may be off. `key` is
/// that of the audit.
int in_pairs(double draws, uint64_t key);

/// Draws of pixels: where few probes have little else to tell them more than elsewhere, where the
/// mean of many does fewer.
int least_pixels(const JobSpec& job);

}  // namespace probebake
