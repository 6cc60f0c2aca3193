#include "light/sky_file.h"

#include <cmath>
#include <cstring>

#include "image/exr_file.h"
#include "image/hdr.h"
#include "io/file.h"
#include "io/io_error.h"

namespace probebake {
namespace {

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
    for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) {
            const Rgb& c = image.at(x, y);
            if (!is_finite(Vec3(c)) || !(c.r >= 0.0f && c.g >= 0.0f && c.b >= 0.0f)) {
                throw IoError(name, "the pixel " + std::to_string(x) + ", " + std::to_string(y) +
                                        " is negative or not finite");
            }
        }
    }
    return std::make_shared<const Image>(std::move(image));
}

std::shared_ptr<const Image> read_sky(const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    std::vector<std::byte> bytes;
    try {
        bytes = read_file(path, kMaxSkyFileBytes);
    } catch (const IoError&) {
        throw IoError(name, "cannot be read, expected a file of at most " +
                                std::to_string(kMaxSkyFileBytes >> 20) + " MiB");
    }
    return decode_sky(bytes, name);
}

}  // namespace probebake
