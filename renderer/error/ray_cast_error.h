// The error table as the thesis builds it, by casting rays (Müller 2020, 3.1.2, 3.2, Algorithm 1).
//
// An orthographic camera looks along d at a cube of side 1; its frame buffer of R × R pixels covers
// [−1, 1]², more than the cube's bounding sphere. The frame is cut into four quarters of (R/2)²
// correlated multi-jittered samples each (3.2.1); a set of four rays takes one from each. Rays that
// miss the parent are not counted, so the parent's mean is 1.
//
// The rays are the same for every mask. Each is cast once, against all eight octants; the set of
// octants that it passes (up to four) is counted in a histogram, and the rays that miss all
// children of a mask are those whose set is disjoint from it. No ray is left out and none is
// approximated: the counts are those of Algorithm 1.
#pragma once

#include "error/error_table.h"

namespace probebake {

inline constexpr int kThesisFramePx = 512;

/// The table over `directions`. frame_px is even, 8 to 4096; the thesis uses 64, 128, 256, 512.
/// Throws std::invalid_argument otherwise, and for directions that are not of unit length.
ErrorTable ray_cast_errors(std::vector<Vec3> directions, int frame_px = kThesisFramePx);

}  // namespace probebake
