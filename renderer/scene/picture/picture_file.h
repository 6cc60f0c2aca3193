// PNG and JPEG files in: 16-bit grey, or 8-bit sRGB colours, with alpha on request.
//
// stb_image decodes, but checks neither PNG's checksums nor, reliably, that a file is whole: the
// chunks of a PNG and the end of a JPEG are checked here first, so that a damaged file is refused
// and never read as a slightly different picture. Source of the chunk layout: PNG (ISO 15948),
// section 5.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace probebake {

inline constexpr int kMaxPictureSide_px = 16384;

struct GreyPicture {
    int width_px = 0;
    int height_px = 0;
    std::vector<uint16_t> values;  // row by row from the top
};

struct ColorPicture {
    int width_px = 0;
    int height_px = 0;
    std::vector<std::array<uint8_t, 3>> values;  // sRGB, row by row from the top
};

struct RgbaPicture {
    int width_px = 0;
    int height_px = 0;
    std::vector<std::array<uint8_t, 4>> values;  // sRGB and alpha, row by row from the top
};

/// Whether the bytes begin as those of a PNG or a JPEG do.
bool is_png_or_jpeg(std::span<const std::byte> bytes);

/// Throws IoError for anything but a whole PNG of one 16-bit channel.
GreyPicture read_grey_png(std::span<const std::byte> bytes, const std::string& file_name);

/// Throws IoError for anything but a whole PNG or JPEG of 8 bits per channel.
ColorPicture read_color_picture(std::span<const std::byte> bytes, const std::string& file_name);

/// Any number of channels; 16 bits are cut to the upper 8; alpha is 255 where the file has none.
/// Throws IoError for anything but a whole PNG or JPEG, and before decoding one of more pixels than
/// allowed.
RgbaPicture read_rgba_picture(std::span<const std::byte> bytes, const std::string& file_name,
                              uint64_t max_pixels);

}  // namespace probebake
