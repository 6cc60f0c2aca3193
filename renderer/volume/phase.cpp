#include "volume/phase.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace probebake {

double henyey_greenstein(double g, double cosine) {
    const double d = 1.0 + g * g - 2.0 * g * cosine;
    return (1.0 - g * g) / (4.0 * std::numbers::pi * d * std::sqrt(d));
}

// The textbook's (1 + g² − s²) / 2g with its difference of squares multiplied out, which leaves no
// division by g: exact for g = 0 and all small g.
double sample_henyey_greenstein(double g, double u) {
    const double x = 2.0 * u - 1.0;
    const double d = 1.0 + g * x;
    const double s = (1.0 - g * g) / d;
    return std::clamp(0.5 * (g + (x + g) * (1.0 + s) / d), -1.0, 1.0);
}

// Basis without a branch on the pole: Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
Vec3 around(const Vec3& axis, double cosine, double turn) {
    const double sign = std::copysign(1.0, axis.z);
    const double a = -1.0 / (sign + axis.z);
    const double b = axis.x * axis.y * a;
    const Vec3 u(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    const Vec3 v(b, sign + axis.y * axis.y * a, -axis.y);
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    const double angle = 2.0 * std::numbers::pi * turn;
    return glm::normalize(u * (sine * std::cos(angle)) + v * (sine * std::sin(angle)) +
                          axis * cosine);
}

}  // namespace probebake
