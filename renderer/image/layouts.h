// A cubemap on other grids, resampled; never a mere flip, because the grids differ.
//
// Latlong (OpenEXR's, envmap = latlong): 4N wide, 2N high, at most 8192 wide. Pixel (x, y) lies at
// longitude −2π (x / (W−1) − ½) and latitude −π (y / (H−1) − ½), direction (sin lon cos lat, sin
// lat, cos lon cos lat): +Y on top, +Z in the middle, the first and last column the same meridian,
// the first and last row the poles. Every pixel is the mean over its cell, so that no small light
// is lost between two of them; a row of a pole has one value.
//
// GL faces: six N × N images px nx py ny pz nz as OpenGL, Vulkan and KTX store them, texel centres
// half a texel from the edge, the first row at t = 0: texel (x, y) has s = (2x + 1) / N − 1 and
// t = (2y + 1) / N − 1, bilinear.
//
//   face   direction of (s, t)      face   direction of (s, t)
//   px     ( 1, −t, −s)             nx     (−1, −t,  s)
//   py     ( s,  1,  t)             ny     ( s, −1, −t)
//   pz     ( s, −t,  1)             nz     (−s, −t, −1)
//
// Source: OpenEXR's ImfEnvmap.h; OpenGL 4.6, table 8.19.
#pragma once

#include "image/cubemap.h"

namespace probebake {

inline constexpr int kMaxLatlongWidth_px = 8192;
constexpr int latlong_width(int face_size_px) {
    return face_size_px * 4 < kMaxLatlongWidth_px ? face_size_px * 4 : kMaxLatlongWidth_px;
}

Vec3 latlong_direction(double x, double y, int width_px, int height_px);
Image latlong_of(const Cubemap& cubemap);

inline constexpr std::array<const char*, kFaceCount> kGlFaceNames = {"px", "nx", "py",
                                                                     "ny", "pz", "nz"};
Vec3 gl_direction(CubeFace face, double s, double t);
Image gl_face_of(const Cubemap& cubemap, CubeFace face);

}  // namespace probebake
