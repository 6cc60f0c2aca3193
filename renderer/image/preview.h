// A cubemap as a picture for people: a tone-mapped 8-bit PNG.
//
// Tone curve, per channel: x = radiance / exposure; with `shoulder`, x above 0.6 becomes
// 0.6 + 0.4 (1 − exp(−(x − 0.6) / 0.4)), which leaves darker colours alone and reaches 1 at
// infinity; then clipped to [0, 1], sRGB encoded (IEC 61966-2-1) and rounded.
//
// Cross, 4N × 3N, seen from inside with −Z ahead; every face as stored, unturned, black around:
//          +Y                 Neighbouring faces share the pixels along their border, which the
//      −X  −Z  +X  +Z         cross therefore shows twice.
//          −Y
//
// Panorama, 2H × H, equirectangular, +Z in the centre and −X to the right of it, +Y on top
// (the longitudes of OpenEXR's latlong); pixels are at texel centres.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/cubemap.h"

namespace probebake {

struct ToneCurve {
    double exposure = 1.0;  // the radiance that is shown as 1
    bool shoulder = false;
};

/// The three bytes of a colour's pixel.
std::array<uint8_t, 3> tone_mapped(const Rgb& color, const ToneCurve& tone);

/// A count as a grey: up to 1 black, `white` (above 1) 1, by its logarithm.
Rgb count_grey(double count, double white);

/// PNG files. Throws std::invalid_argument where a side would be empty or exceed 16384 pixels or
/// the exposure is not positive.
std::vector<std::byte> encode_image_png(const Image& image, const ToneCurve& tone);
std::vector<std::byte> encode_cross_png(const Cubemap& cubemap, const ToneCurve& tone);
std::vector<std::byte> encode_panorama_png(const Cubemap& cubemap, int height_px,
                                           const ToneCurve& tone);

}  // namespace probebake
