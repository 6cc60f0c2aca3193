#include "scene/picture/picture_file.h"

#include <stb/stb_image.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string_view>

#include "io/byte_reader.h"

namespace probebake {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n"sv;
constexpr std::string_view kJpegStart = "\xFF\xD8\xFF"sv;
constexpr std::string_view kJpegEnd = "\xFF\xD9"sv;

bool starts_with(std::span<const std::byte> bytes, std::string_view text) {
    return bytes.size() >= text.size() &&
           std::equal(text.begin(), text.end(), bytes.begin(),
                      [](char a, std::byte b) { return static_cast<std::byte>(a) == b; });
}

/// CRC-32 as PNG and zlib have it: reflected, polynomial 0xEDB88320.
uint32_t crc32(std::span<const std::byte> bytes) {
    static const std::array<uint32_t, 256> table = [] {
        std::array<uint32_t, 256> made{};
        for (uint32_t i = 0; i < made.size(); ++i) {
            uint32_t value = i;
            for (int bit = 0; bit < 8; ++bit) {
                value = (value & 1u) != 0 ? value >> 1 ^ 0xEDB88320u : value >> 1;
            }
            made[i] = value;
        }
        return made;
    }();
    uint32_t crc = 0xFFFFFFFFu;
    for (const std::byte b : bytes) {
        crc = table[(crc ^ std::to_integer<uint32_t>(b)) & 255u] ^ crc >> 8;
    }
    return ~crc;
}

uint32_t big_endian(uint32_t value) { return __builtin_bswap32(value); }

/// Every chunk whole and with its checksum, IHDR first, IEND last and nothing behind it.
void check_png(std::span<const std::byte> bytes, const std::string& file) {
    ByteReader reader(file, bytes);
    reader.take(kPngSignature.size(), "the signature");
    for (bool first = true;; first = false) {
        const uint64_t at = reader.offset();
        const uint32_t length = big_endian(reader.read<uint32_t>("the length of a chunk"));
        const auto name_and_data = reader.take(uint64_t{length} + 4, "a chunk");
        const std::string_view name(reinterpret_cast<const char*>(name_and_data.data()), 4);
        if (crc32(name_and_data) != big_endian(reader.read<uint32_t>("the checksum of a chunk"))) {
            throw IoError(file, at, "the checksum of a PNG chunk does not match its content");
        }
        if (first != (name == "IHDR")) {
            throw IoError(file, at, "expected one IHDR chunk, at the start of the PNG");
        }
        if (name == "IEND") break;
    }
    if (reader.remaining() != 0) {
        throw IoError(file, reader.offset(), "bytes follow the end of the PNG");
    }
}

/// What the header promises; throws where the decoder will not read it.
struct Header {
    int width_px = 0;
    int height_px = 0;
    int channels = 0;
    bool deep = false;
};

struct FreeStb {
    void operator()(void* pixels) const { stbi_image_free(pixels); }
};

class Decoder {
  public:
    Decoder(std::span<const std::byte> bytes, const std::string& file)
        : data_(reinterpret_cast<const stbi_uc*>(bytes.data())),
          size_(static_cast<int>(bytes.size())),
          file_(file) {
        if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) {
            throw IoError(file, "has more than 2 GiB, too large for a picture");
        }
        if (starts_with(bytes, kPngSignature)) {
            png_ = true;
            check_png(bytes, file);
        } else if (starts_with(bytes, kJpegStart)) {
            if (!starts_with(bytes.last(kJpegEnd.size()), kJpegEnd)) {
                throw IoError(file, bytes.size(), "the JPEG has no end marker: it is cut off");
            }
        } else {
            throw IoError(file, 0, "is neither a PNG nor a JPEG");
        }
        if (stbi_info_from_memory(data_, size_, &header_.width_px, &header_.height_px,
                                  &header_.channels) == 0) {
            fail();
        }
        header_.deep = stbi_is_16_bit_from_memory(data_, size_) != 0;
        if (header_.width_px < 1 || header_.height_px < 1 ||
            header_.width_px > kMaxPictureSide_px || header_.height_px > kMaxPictureSide_px) {
            throw IoError(file, "is " + std::to_string(header_.width_px) + " x " +
                                    std::to_string(header_.height_px) +
                                    " pixels, expected sides of 1 to " +
                                    std::to_string(kMaxPictureSide_px));
        }
    }

    bool png() const { return png_; }
    const Header& header() const { return header_; }
    size_t pixels() const {
        return static_cast<size_t>(header_.width_px) * static_cast<size_t>(header_.height_px);
    }

    std::vector<uint16_t> grey() const {
        int w = 0;
        int h = 0;
        int channels = 0;
        const std::unique_ptr<stbi_us, FreeStb> decoded(
            stbi_load_16_from_memory(data_, size_, &w, &h, &channels, 1));
        if (!decoded) fail();
        return {decoded.get(), decoded.get() + pixels()};
    }

    /// As many channels of 8 bits as Texel has.
    template <class Texel>
    std::vector<Texel> texels() const {
        constexpr size_t kChannels = sizeof(Texel);
        int w = 0;
        int h = 0;
        int channels = 0;
        const std::unique_ptr<stbi_uc, FreeStb> decoded(
            stbi_load_from_memory(data_, size_, &w, &h, &channels, static_cast<int>(kChannels)));
        if (!decoded) fail();
        std::vector<Texel> values(pixels());
        std::memcpy(values.data(), decoded.get(), kChannels * values.size());
        return values;
    }

  private:
    [[noreturn]] void fail() const {
        const char* reason = stbi_failure_reason();
        throw IoError(file_, std::string("cannot be decoded: ") +
                                 (reason != nullptr ? reason : "no reason given"));
    }

    const stbi_uc* data_;
    int size_;
    const std::string& file_;
    bool png_ = false;
    Header header_;
};

}  // namespace

GreyPicture read_grey_png(std::span<const std::byte> bytes, const std::string& file_name) {
    const Decoder decoder(bytes, file_name);
    const Header& header = decoder.header();
    if (!decoder.png() || !header.deep || header.channels != 1) {
        throw IoError(file_name, "has " + std::to_string(header.channels) + " channels of " +
                                     (header.deep ? "16" : "8") +
                                     " bits, expected a PNG of one channel of 16");
    }
    return {header.width_px, header.height_px, decoder.grey()};
}

ColorPicture read_color_picture(std::span<const std::byte> bytes, const std::string& file_name) {
    const Decoder decoder(bytes, file_name);
    const Header& header = decoder.header();
    if (header.deep) throw IoError(file_name, "has 16 bits per channel, expected 8");
    return {header.width_px, header.height_px, decoder.texels<std::array<uint8_t, 3>>()};
}

bool is_png_or_jpeg(std::span<const std::byte> bytes) {
    return starts_with(bytes, kPngSignature) || starts_with(bytes, kJpegStart);
}

RgbaPicture read_rgba_picture(std::span<const std::byte> bytes, const std::string& file_name,
                              uint64_t max_pixels) {
    const Decoder decoder(bytes, file_name);
    if (decoder.pixels() > max_pixels) {
        throw IoError(file_name, "has " + std::to_string(decoder.pixels()) +
                                     " pixels, expected at most " + std::to_string(max_pixels));
    }
    const Header& header = decoder.header();
    return {header.width_px, header.height_px, decoder.texels<std::array<uint8_t, 4>>()};
}

}  // namespace probebake
