// The exposure that images are divided by before they are compared or shown.
//
// The 99th percentile of luminance maps to 1, by nearest rank: of n values sorted upwards, the
// ⌈0.99 n⌉-th. Where it is 0 (an emitter that fills less than a hundredth) the exposure is 1.
// Source: docs/conventions.md, "Image metrics".
#pragma once

#include <span>

#include "math/vec.h"

namespace probebake {

/// The exposure of a non-empty set of pixels. Throws std::invalid_argument where it is empty,
/// std::domain_error where a luminance is not finite.
double exposure_of(std::span<const Rgb> pixels);

}  // namespace probebake
