// What the noise of single pixels comes to in the irradiance of a cubemap.
//
// Where pixels err without bias and independently, as leaf rays and paths do, the error of the nine
// coefficients of irradiance has the expected squared length Σ_p w_p² var_p Σ_lm A_l² Y_lm(p)², w
// the solid angles. By the addition theorem Σ_m Y_lm² = (2l + 1) / 4π in every direction: a sample
// of pixels' variances tells the error, though no sample of pixels tells the irradiance.
//
// The shifts of leaf rays are spread more evenly than independent ones (grid_shift): what is
// predicted then is rather too large than too small (docs/decisions.md).
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "bake/job_spec.h"
#include "image/cubemap.h"
#include "math/estimate.h"
#include "render/cost_stats.h"

namespace probebake {

/// A stored pixel that was drawn with the same probability as any other of its probe's cubemap.
struct NoisyPixel {
    size_t probe = 0;
    CubePixel pixel;
    int face_size_px = 0;
    double variance = 0.0;  // estimated without bias; summed over R, G, B
};

/// Length of the irradiance (irradiance_norm) seen from each probe of a sample.
struct IrradianceNorms {
    std::map<size_t, double> of_probe;
    CostStats cost;
};

/// A pixel of a coarse cubemap.
struct CoarsePixel {
    ProbeSpec probe;  // its faces' size changed
    CubePixel pixel;
    uint64_t index = 0;  // differs between all pixels of all probes
};
using SeeCoarsely = std::function<Rgb(const CoarsePixel&, CostStats&)>;

/// By coarse cubemaps. Runs on the calling arena.
IrradianceNorms coarse_irradiance_norms(const std::vector<ProbeSpec>& probes,
                                        const std::vector<NoisyPixel>& sample,
                                        const SeeCoarsely& see);

/// The square of irradiance_rel, mean over the drawn pixels' probes. None where a probe that sees
/// noise seems to see nothing.
std::optional<Estimate> expected_irradiance_square(const std::vector<NoisyPixel>& sample,
                                                   const IrradianceNorms& norms);

}  // namespace probebake
