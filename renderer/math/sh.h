// Real spherical harmonics of orders 0 to 2.
//
// Orthonormal over the sphere, no Condon-Shortley sign, order L00, L1-1 (y), L10 (z), L11 (x),
// L2-2 (xy), L2-1 (yz), L20 (3z²−1), L21 (xz), L22 (x²−y²) (docs/conventions.md).
#pragma once

#include <array>
#include <numbers>

#include "math/vec.h"

namespace probebake {

inline constexpr int kShCount = 9;
using Sh9 = std::array<double, kShCount>;

/// Irradiance over radiance, coefficient by coefficient: π, 2π/3 and π/4 (Ramamoorthi and Hanrahan
/// 2001).
inline constexpr Sh9 kShIrradiance = [] {
    Sh9 factors{};
    for (size_t i = 0; i < factors.size(); ++i) {
        factors[i] = std::numbers::pi * (i == 0 ? 1.0 : i < 4 ? 2.0 / 3.0 : 0.25);
    }
    return factors;
}();
/// Largest irradiance of radiance whose coefficients have length 1, over all normals:
/// √Σ A_l² (2l + 1) / 4π (the addition theorem: Σ_m Y_lm² = (2l + 1) / 4π in every direction).
inline constexpr double kShLargestIrradiance = 1.4415;

/// The nine basis functions at the unit direction d.
inline Sh9 sh_basis(const Vec3& d) {
    return {0.28209479177387814,
            0.4886025119029199 * d.y,
            0.4886025119029199 * d.z,
            0.4886025119029199 * d.x,
            1.0925484305920792 * d.x * d.y,
            1.0925484305920792 * d.y * d.z,
            0.31539156525252005 * (3.0 * d.z * d.z - 1.0),
            1.0925484305920792 * d.x * d.z,
            0.5462742152960396 * (d.x * d.x - d.y * d.y)};
}

inline double sh_dot(const Sh9& a, const Sh9& b) {
    double sum = 0.0;
    for (int i = 0; i < kShCount; ++i) sum += a[static_cast<size_t>(i)] * b[static_cast<size_t>(i)];
    return sum;
}

}  // namespace probebake
