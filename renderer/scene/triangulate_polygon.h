// A flat polygon, concave too, cut into triangles by clipping ears.
//
// Works in the plane of the axes across which the polygon's area is largest (its normal by Newell);
// polygons with holes come as a single ring that runs along a bridge twice. Corners are never moved
// or left out: n corners give n − 2 triangles, of no area where the corners leave no choice.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "math/vec.h"

namespace probebake {

/// Concave polygons of more corners are refused: clipping takes the cube of them at worst.
inline constexpr size_t kMaxConcaveCorners = 1024;

/// Indices into the corners, turning as they do; none for fewer than three corners; no value for a
/// concave polygon of too many.
std::optional<std::vector<std::array<uint32_t, 3>>> triangulate_polygon(
    std::span<const Vec3> corners);

}  // namespace probebake
