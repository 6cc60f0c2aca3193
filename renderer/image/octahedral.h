// The sphere on a square, as RTXGI's probes have it: the octahedral map with a border of one texel.
//
// A tile has T × T texels inside a border, (T+2)² in all. Texel (i, j) of the inside, i to the
// right and j down, lies at the square's point (2i+1)/T − 1, (2j+1)/T − 1 in [−1, 1]²; +Z is its
// middle, −Z its four corners, x to the right, y down (whatever axis is up in the world). A border
// texel repeats the inside texel that lies beside it on the sphere, so that bilinear lookups need
// no special case:
//
//   row 0, column i        <- row 1, column T+1−i           (row T+1 likewise from row T)
//   column 0, row j        <- column 1, row T+1−j           (column T+1 likewise from column T)
//   corner                 <- inside texel at the opposite corner
//
// Source: Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit
// Vectors"; RTXGI-DDGI, docs/DDGIVolume.md, "Probe Irradiance and Distance Atlases".
#pragma once

#include "image/image.h"

namespace probebake {

/// The unit direction of a point of the square.
Vec3 octahedral_direction(double x, double y);
/// The point of a direction of any length but zero.
Vec2 octahedral_point(const Vec3& direction);

/// The direction of texel (x, y) of the inside, counted from its first one.
Vec3 octahedral_texel_direction(int x, int y, int inside_px);

/// Fills the border of the tile whose corner is (left, top), from its inside.
void fill_octahedral_border(Image& image, int left, int top, int inside_px);

}  // namespace probebake
