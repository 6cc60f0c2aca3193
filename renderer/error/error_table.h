// The visibility error e(d, mask) sampled over directions, as every builder here returns it.
//
// e = 1 − (rays along d that hit a filled child) / (rays along d that hit the parent cube): the
// share of what a node shows of itself that its children would let through. e(d, 0) = 1,
// e(d, 255) = 0, e(d) = e(−d), and adding a child never raises it (Müller 2020, 3.1).
#pragma once

#include <span>
#include <vector>

#include "error/child_mask.h"

namespace probebake {

struct ErrorTable {
    std::vector<Vec3> directions;    // unit
    std::vector<MaskErrors> errors;  // errors[direction][mask]
};

/// Directions of the thesis's table (3.2). It does not say which ones.
inline constexpr int kThesisDirections = 256;

/// `count` unit directions spread evenly over the sphere: a spherical Fibonacci set, one direction
/// at the middle height of each of `count` bands of equal area, a golden angle apart (González
/// 2010, "Measurement of Areas on a Sphere Using Fibonacci and Latitude-Longitude Lattices").
std::vector<Vec3> even_directions(int count = kThesisDirections);

/// How far the length of a unit direction may be from 1: what six decimals per component cost.
inline constexpr double kUnitTolerance = 1e-6;

/// Throws std::invalid_argument unless every direction is finite and of unit length.
void require_unit(std::span<const Vec3> directions);

}  // namespace probebake
