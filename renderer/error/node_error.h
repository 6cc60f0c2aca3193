// The error of stopping a ray at a node, and the decision to refine (Müller 2020, 5.1.3, 5.1.4).
//
//   E_N(r) = e(r, N) + d/|C| · Σ_c e(r, c)        C: the node's children, d: the decay
//
// The first term is what the node itself hides; the second lets a node that looks solid be refined
// when its children do not, shared among them so that nodes with many children are not favoured.
// Voxels are full (mask 255), their e is 0: above the voxels E_N is e(r, N) alone.
//
// e is linear in its SH coefficients: e(r, m) = k_m · Y(r). So E_N = (k_N + d/|C| · Σ_c k_c) ·
// Y(r), one sum of rows and one dot product, whatever the number of children.
//
// Decision: where E_N exceeds the threshold the ray is discarded and 2 × 2 rays are cast one level
// finer. E_N is no share: with d it may reach 1 + d, and the fit's undershoot may make it negative.
#pragma once

#include <span>

#include "error/sh_error.h"

namespace probebake {

/// The thesis's settings, found on its desert for the ray count of its adaptive renderer (5.1.4).
inline constexpr double kThesisDecay = 0.2;
inline constexpr double kThesisThreshold = 0.154;

/// E_N for a unit direction. `child_masks` holds the masks of the node's |C| children; empty for a
/// voxel.
inline double node_error(const ShErrorTable& table, const Vec3& direction, uint8_t own_mask,
                         std::span<const uint8_t> child_masks, double decay) {
    std::array<float, kShCount> children{};
    for (const uint8_t mask : child_masks) {
        const auto row = table.coefficients(mask);
        for (size_t i = 0; i < kShCount; ++i) children[i] += row[i];
    }
    const double share =
        child_masks.empty() ? 0.0 : decay / static_cast<double>(child_masks.size());
    const auto own = table.coefficients(own_mask);
    Sh9 sum{};
    for (size_t i = 0; i < kShCount; ++i) sum[i] = own[i] + share * children[i];
    return sh_dot(sum, sh_basis(direction));
}

/// Whether to go one level finer; an error that is not a number does.
inline bool needs_refinement(double node_error, double threshold) {
    return !(node_error <= threshold);
}

}  // namespace probebake
