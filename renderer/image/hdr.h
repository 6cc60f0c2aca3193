// Radiance pictures (.hdr): three 8-bit mantissas and one shared exponent per pixel, plain or
// run-length encoded by scanline (Ward 1991, "Real Pixels"; the format's "new" run lengths).
//
// Value = mantissa · 2^(exponent − 136), as stb_image and OpenImageIO have it (Radiance itself adds
// half a step to the mantissa: at most 0.4 % of the largest component). Only "-Y H +X W" (rows from
// the top, pixels from the left) and 32-bit_rle_rgbe; EXPOSURE lines are ignored. Untrusted bytes
// are safe: stb_image itself hangs on a file that ends within a run (of length 0), so it is not
// used.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "image/image.h"

namespace probebake {

/// Throws IoError with `file` and the offset for anything but a whole picture of at most
/// max_width × max_height.
Image decode_hdr(std::span<const std::byte> bytes, const std::string& file, int max_width,
                 int max_height);

}  // namespace probebake
