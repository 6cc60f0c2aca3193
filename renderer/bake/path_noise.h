// What a render through media says of its own error: paths err without bias and independently, so
// that the variances of its pixels tell it.
#pragma once

#include "bake/irradiance_noise.h"
#include "bake/pilot.h"
#include "image/cubemap.h"
#include "render/render.h"

namespace probebake {

/// Of a render and how its file holds it. All outlive it.
class PathNoise {
  public:
    PathNoise(const CubemapRender& render, const Cubemap& as_written, const Pilot& pilot)
        : render_(render), as_written_(as_written), pilot_(pilot) {}

    /// By this probe's paths and by those of the pilot: half by each.
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
};

}  // namespace probebake
