// What a render's variances say of its error: paths through media, and leaf rays of shifted grids,
// err without bias and independently.
#pragma once

#include "bake/irradiance_noise.h"
#include "bake/pilot.h"
#include "image/cubemap.h"
#include "render/render.h"

namespace probebake {

/// Of a render and how its file holds it. All outlive it.
class RenderNoise {
  public:
    /// `mse`: of leaf rays, which do not tell their variance; what the pilot found (metrics'
    /// units).
    RenderNoise(const CubemapRender& render, const Cubemap& as_written, const Pilot& pilot,
                std::optional<double> mse = {})
        : render_(render), as_written_(as_written), pilot_(pilot), mse_(mse) {}

    /// Of paths by the probe's own and by those of the pilot, half by each; of leaf rays by the
    /// pilot's.
    IrradianceNoise irradiance() const;

    /// 1 − SSIM to be expected, mean over all windows of all faces (ssim_lost_to_noise), channels
    /// taken to err together; luminances beyond white do not err. 0 below faces of 11 pixels.
    double ssim_lost() const;

    /// By what factor variances have to fall for a target (irradiance_rel or SSIM) to be expected;
    /// 1 and more: they need not.
    double step(const QualityTarget& target, const Steering& steering) const;

  private:
    const CubemapRender& render_;
    const Cubemap& as_written_;
    const Pilot& pilot_;
    std::optional<double> mse_;
};

}  // namespace probebake
