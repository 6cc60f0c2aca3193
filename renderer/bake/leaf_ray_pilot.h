// The pilot where irradiance is all that is asked for: leaf rays of shifted grids, which err
// without bias and independently. Nothing is searched: probes begin with one ray in every pixel and
// get finer grids until they meet the target.
#pragma once

#include "bake/pilot.h"

namespace probebake {

/// Settings of one leaf ray per pixel, and finer ones. Their squared errors are in units of what
/// one ray leaves: they fall like the variance of stratified means, and so does the square of an
/// audit's interval that costs a share of its render (irradiance_truth_grid).
void begin_with_one_ray(Pilot& pilot);

/// Of the curve: one leaf ray, and the first that are finer.
std::vector<RenderSettings> leaf_ray_curve(const Pilot& pilot);

/// Probes whose irradiance is pooled (audit_size.h) go by what the curve measured; beyond it errors
/// are taken to fall as those of independent rays, as they do where a pixel holds much.
void learn_from_leaf_ray_curve(Pilot& pilot, const JobSpec& job);

}  // namespace probebake
