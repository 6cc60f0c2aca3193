#include "light/sky_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "image/exr_file.h"
#include "image/hdr.h"
#include "io/checked_file.h"
#include "io/file_beneath.h"
#include "io/sha256.h"

namespace probebake {
namespace {

constexpr std::string_view kKind = "sky";
constexpr uint64_t kVersion = 1;

bool begins_with(std::span<const std::byte> bytes, std::string_view text) {
    return bytes.size() >= text.size() && std::memcmp(bytes.data(), text.data(), text.size()) == 0;
}

void check_size(int width, int height, const std::string& name) {
    if (width < 2 || width > kMaxSkyWidth_px || width != 2 * height) {
        throw IoError(name, "is " + std::to_string(width) + " x " + std::to_string(height) +
                                " pixels, expected twice as wide as high and at most " +
                                std::to_string(kMaxSkyWidth_px) + " wide");
    }
}

Image decode_exr(std::span<const std::byte> bytes, const std::string& name) {
    ExrReader reader(bytes, name, kMaxSkyWidth_px, kMaxSkyWidth_px / 2);
    check_size(reader.width(), reader.height(), name);
    Image image(reader.width(), reader.height());
    auto* first = reinterpret_cast<std::byte*>(image.pixels().data());
    const ExrChannel<std::byte> channels[] = {
        {"R", Imf::FLOAT, first, sizeof(Rgb)},
        {"G", Imf::FLOAT, first + sizeof(float), sizeof(Rgb)},
        {"B", Imf::FLOAT, first + 2 * sizeof(float), sizeof(Rgb)}};
    reader.read(channels);
    return image;
}

void check_pixels(const Image& image, const std::string& name) {
    for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) {
            const Rgb& c = image.at(x, y);
            if (!is_finite(Vec3(c)) || !(c.r >= 0.0f && c.g >= 0.0f && c.b >= 0.0f)) {
                throw IoError(name, "the pixel " + std::to_string(x) + ", " + std::to_string(y) +
                                        " is negative or not finite");
            }
        }
    }
}

struct Header {
    int64_t width_px = 0;
    int64_t height_px = 0;
    std::array<char, 64> sha256{};
};

}  // namespace

std::shared_ptr<const Image> decode_sky(std::span<const std::byte> bytes, const std::string& name) {
    Image image;
    if (begins_with(bytes, "\x76\x2f\x31\x01")) {
        image = decode_exr(bytes, name);
    } else if (begins_with(bytes, "#?RADIANCE") || begins_with(bytes, "#?RGBE")) {
        image = decode_hdr(bytes, name, kMaxSkyWidth_px, kMaxSkyWidth_px / 2);
        check_size(image.width(), image.height(), name);
    } else {
        throw IoError(name, "is neither an OpenEXR nor a Radiance picture");
    }
    check_pixels(image, name);
    return std::make_shared<const Image>(std::move(image));
}

SkyFile read_sky_file(const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    std::vector<std::byte> bytes;
    try {
        bytes = read_file_beneath(path, kMaxSkyFileBytes);
    } catch (const IoError&) {
        throw IoError(name, "cannot be read, expected a file of at most " +
                                std::to_string(kMaxSkyFileBytes >> 20) + " MiB");
    }
    return {decode_sky(bytes, name), sha256_hex(bytes)};
}

void save_sky(const std::filesystem::path& path, const SkyFile& sky) {
    std::array<Header, 1> header{{{sky.image->width(), sky.image->height(), {}}}};
    sky.sha256.copy(header[0].sha256.data(), header[0].sha256.size());
    const std::array<std::span<const std::byte>, 2> sections = {std::as_bytes(std::span(header)),
                                                                std::as_bytes(sky.image->pixels())};
    write_checked_file(path, kKind, kVersion, sections);
}

SkyFile load_sky(const std::filesystem::path& path) {
    const CheckedFile file(path, kKind, kVersion);
    if (file.section_count() != 2) throw IoError(file.name(), "expected 2 sections");
    const std::vector<Header> header = file.array<Header>(0);
    const std::vector<Rgb> pixels = file.array<Rgb>(1);
    if (header.size() != 1) throw IoError(file.name(), "expected one header");
    const auto [width_px, height_px, sha256] = header[0];
    if (width_px > kMaxSkyWidth_px || height_px > kMaxSkyWidth_px) {
        throw IoError(file.name(), "is too large");
    }
    check_size(static_cast<int>(width_px), static_cast<int>(height_px), file.name());
    Image image(static_cast<int>(width_px), static_cast<int>(height_px));
    if (pixels.size() != image.pixels().size()) throw IoError(file.name(), "is not whole");
    std::copy(pixels.begin(), pixels.end(), image.pixels().begin());
    check_pixels(image, file.name());
    return {std::make_shared<const Image>(std::move(image)), {sha256.data(), sha256.size()}};
}

}  // namespace probebake
