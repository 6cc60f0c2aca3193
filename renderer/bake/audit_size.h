// How much an audit draws, where that is not a matter of pixels alone.
#pragma once

#include "bake/job_spec.h"
#include "bake/quality.h"

namespace probebake {

/// Pixels that an audit draws at least, where its rays pay for fewer, and at most.
struct DrawBounds {
    int least = 0;
    int most = 0;
};

/// At least more where few probes have little else to tell them, fewer where the mean of many does.
DrawBounds pixel_draws(const JobSpec& job, int face_size_px);
/// For irradiance, which needs many: at least 64 (8 where the mean of a job's probes tells) and a
/// hundredth of the texels.
DrawBounds irradiance_draws(const JobSpec& job, int face_size_px);

/// Whether a probe of leaf rays has so few pixels that no audit of its own tells its irradiance for
/// what audits may cost, and others of its job tell as well.
bool irradiance_is_pooled(const JobSpec& job, int face_size_px);

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
    double lot = 0.0;                      // of the probe (audit_lot)
};

/// Rays per side are 0.6 of the root of a pixel's, fewer than in single pixels (audit.h): windows
/// average over their noise. As many windows as these rays pay for, at least 16, or 2 in jobs of
/// many probes; where they are pooled as many as the rays pay for on average, in pairs:
/// none in most probes of small faces.
WindowDraws ssim_windows(const WindowParams& params, double rays);

/// A probe's lot, 0 to 1: which probes of a job have the audits that all of them pay for. Spread
/// evenly over a job's probes, and the same in all looks: else a further look, not what was found,
/// would be what brings an audit.
double audit_lot(uint64_t key, size_t probe);
/// So many draws on average over the lots, in pairs: a single one does not tell how far it may be
/// off.
int in_pairs(double draws, double lot);

}  // namespace probebake
