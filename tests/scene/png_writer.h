// PNG files byte by byte, uncompressed: 16-bit grey and 8-bit RGB, and damaged ones on request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace probebake::test {

inline std::string big_endian_bytes(uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) {
        bytes.push_back(static_cast<char>(value >> shift & 255u));
    }
    return bytes;
}

/// The checksum bit by bit, as the PNG specification defines it.
inline uint32_t png_crc(std::string_view bytes) {
    uint32_t crc = 0xFFFFFFFFu;
    for (const char c : bytes) {
        crc ^= static_cast<uint8_t>(c);
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (0xEDB88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

inline std::string png_chunk(const std::string& name, const std::string& data) {
    return big_endian_bytes(static_cast<uint32_t>(data.size())) + name + data +
           big_endian_bytes(png_crc(name + data));
}

/// A zlib stream of stored blocks.
inline std::string stored_zlib(const std::string& data) {
    std::string out = "\x78\x01";
    constexpr size_t kBlock = 65535;
    for (size_t at = 0; at < data.size() || at == 0; at += kBlock) {
        const std::string block = data.substr(at, kBlock);
        const auto n = static_cast<uint32_t>(block.size());
        out.push_back(at + kBlock >= data.size() ? '\1' : '\0');
        for (const uint32_t length : {n, ~n}) {
            out.push_back(static_cast<char>(length & 255u));
            out.push_back(static_cast<char>(length >> 8 & 255u));
        }
        out += block;
    }
    uint32_t a = 1;
    uint32_t b = 0;
    for (const char c : data) {
        a = (a + static_cast<uint8_t>(c)) % 65521u;
        b = (b + a) % 65521u;
    }
    return out + big_endian_bytes(b << 16 | a);
}

struct PngPicture {
    uint32_t width_px = 1;
    uint32_t height_px = 1;
    uint8_t bits = 16;
    uint8_t color_type = 0;  // 0 grey, 2 RGB
    std::string samples;     // big-endian, row by row
};

inline std::string png_file(const PngPicture& picture) {
    std::string header = big_endian_bytes(picture.width_px) + big_endian_bytes(picture.height_px);
    for (const int field : {int{picture.bits}, int{picture.color_type}, 0, 0, 0}) {
        header.push_back(static_cast<char>(field));
    }
    std::string rows;
    const size_t row = picture.height_px == 0 ? 0 : picture.samples.size() / picture.height_px;
    for (uint32_t y = 0; y < picture.height_px; ++y) {
        rows += '\0' + picture.samples.substr(y * row, row);  // filter: none
    }
    return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + png_chunk("IDAT", stored_zlib(rows)) +
           png_chunk("IEND", "");
}

inline std::string grey_png(uint32_t width_px, const std::vector<uint16_t>& values) {
    PngPicture picture{.width_px = width_px,
                       .height_px = static_cast<uint32_t>(values.size()) / width_px};
    for (const uint16_t value : values) {
        picture.samples.push_back(static_cast<char>(value >> 8));
        picture.samples.push_back(static_cast<char>(value & 255));
    }
    return png_file(picture);
}

inline std::string rgb_png(uint32_t width_px, const std::string& samples) {
    return png_file({.width_px = width_px,
                     .height_px = static_cast<uint32_t>(samples.size()) / 3 / width_px,
                     .bits = 8,
                     .color_type = 2,
                     .samples = samples});
}

}  // namespace probebake::test
