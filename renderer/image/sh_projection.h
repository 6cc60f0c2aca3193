// A cubemap's radiance as spherical harmonics of orders 0 to 2 (math/sh.h).
//
// Every stored pixel counts with the solid angle of its cell, clipped at the edge of the face
// (pixel_solid_angle): the pixels on the edges, which lie on several faces, count once.
#pragma once

#include "image/cubemap.h"
#include "math/sh.h"

namespace probebake {

/// Coefficients of red, green and blue.
using ShRgb = std::array<Vec3, kShCount>;

/// The basis functions in the direction of a pixel's centre.
Sh9 sh_basis(const CubePixel& pixel, int face_size_px);

ShRgb project_sh(const Cubemap& cubemap);

}  // namespace probebake
