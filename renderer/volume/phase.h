// Henyey-Greenstein's phase function (1941): where scattered light goes.
//
//   p(cos) = (1 − g²) / (4π (1 + g² − 2 g cos)^(3/2)),   cos between the directions of travel
//
// g in (−1, 1), positive forwards. The sampled cosine divides by nothing that vanishes with g (the
// textbook's form is 0/0 at g = 0 and wrong by 6 % at g = 1e-6 in float).
#pragma once

#include "math/vec.h"

namespace probebake {

/// Density per solid angle, 1/sr.
double henyey_greenstein(double g, double cosine);

/// The cosine of a scattering angle, always in [−1, 1]; u in [0, 1).
double sample_henyey_greenstein(double g, double u);

/// The unit vector at this cosine to the unit vector `axis`, turned by `turn` in [0, 1) of a full
/// turn about it.
Vec3 around(const Vec3& axis, double cosine, double turn);

}  // namespace probebake
