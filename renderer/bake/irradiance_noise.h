// What the noise of single pixels comes to in the irradiance of a cubemap.
//
// Where pixels err without bias and independently, as leaf rays and paths do, the error of the nine
// coefficients of irradiance has the expected squared length Σ_p w_p² var_p Σ_lm A_l² Y_lm(p)², w
// the solid angles. By the addition theorem Σ_m Y_lm² = (2l + 1) / 4π in every direction: a sample
// of pixels' variances tells the error, though no sample of pixels tells the irradiance.
//
// The shifts of leaf rays are spread more evenly than independent ones (grid_shift): what is
// predicted then is rather too large than too small (docs/decisions.md).
//
// The nine errors themselves are a sum over thousands of pixels, normal with the covariance
// S = Σ_p w_p² var_p (A Y)(A Y)ᵀ: their squared length has the mean tr S and, as a weighted sum of
// squares of normals does, the relative standard deviation √(2 tr S²) / tr S, R, G and B taken to
// err together, which is when it is largest.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "bake/job_spec.h"
#include "image/cubemap.h"
#include "math/estimate.h"
#include "render/render.h"

namespace probebake {

/// Of a stored pixel's variance (summed over R, G, B), what it adds to the square of its cubemap's
/// irradiance error.
double irradiance_weight(const CubePixel& pixel, int face_size_px);

/// What pixels' own variances say of a whole cubemap.
struct IrradianceNoise {
    double square = 0.0;  // expected square of irradiance_rel; infinite where the file is black
    double spread = 0.0;  // relative standard deviation of the square that there is
    Vec3 channels{0.0};   // expected ‖ΔL‖² of R, G and B
};
IrradianceNoise irradiance_noise(const Cubemap& as_written, std::span<const PixelAux> aux);

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
    /// Expected square of irradiance_rel times the paths of a cubemap, which it falls with; mean
    /// over the probes. Where few paths carry much light, those of one probe do not tell it.
    double square_times_paths = 0.0;
    CostStats cost;
};

/// A pixel of a coarse cubemap.
struct CoarsePixel {
    ProbeSpec probe;  // its faces' size changed
    CubePixel pixel;
    uint64_t index = 0;  // differs between all pixels of all probes
};
struct CoarseColor {
    Rgb mean{0.0f};
    double variance = 0.0;  // of one path, summed over R, G, B; 0 where that is not asked for
};
using SeeCoarsely = std::function<CoarseColor(const CoarsePixel&, CostStats&)>;

/// By coarse cubemaps. Runs on the calling arena.
IrradianceNorms coarse_irradiance_norms(const std::vector<ProbeSpec>& probes,
                                        const std::vector<NoisyPixel>& sample,
                                        const SeeCoarsely& see);

/// The square of irradiance_rel, mean over the drawn pixels' probes. None where a probe that sees
/// noise seems to see nothing.
std::optional<Estimate> expected_irradiance_square(const std::vector<NoisyPixel>& sample,
                                                   const IrradianceNorms& norms);

}  // namespace probebake
