#include "image/preview.h"

#include <stb/stb_image_write.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace probebake {
namespace {

constexpr int kMaxSide_px = 16384;

struct Place {
    CubeFace face;
    int column;
    int row;
};
constexpr std::array<Place, kFaceCount> kCross = {{{CubeFace::kPosY, 1, 0},
                                                   {CubeFace::kNegX, 0, 1},
                                                   {CubeFace::kNegZ, 1, 1},
                                                   {CubeFace::kPosX, 2, 1},
                                                   {CubeFace::kPosZ, 3, 1},
                                                   {CubeFace::kNegY, 1, 2}}};

double srgb_encoded(double x) {
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
}

uint8_t tone_mapped_channel(double radiance, const ToneCurve& tone) {
    constexpr double kKnee = 0.6;
    double x = radiance / tone.exposure;
    if (tone.shoulder && x > kKnee) {
        x = kKnee + (1.0 - kKnee) * -std::expm1(-(x - kKnee) / (1.0 - kKnee));
    }
    // NaN is shown as black.
    x = x > 0.0 ? std::min(x, 1.0) : 0.0;
    return static_cast<uint8_t>(std::lround(255.0 * srgb_encoded(x)));
}

void append(void* context, void* data, int size) {
    const auto* bytes = static_cast<const std::byte*>(data);
    auto& file = *static_cast<std::vector<std::byte>*>(context);
    file.insert(file.end(), bytes, bytes + size);
}

/// The PNG of an image whose pixels the function gives by column and row.
template <class Function>
std::vector<std::byte> encode_png(int width, int height, const ToneCurve& tone,
                                  const Function& pixel) {
    if (width < 1 || height < 1 || width > kMaxSide_px || height > kMaxSide_px) {
        throw std::invalid_argument("a preview of " + std::to_string(width) + " x " +
                                    std::to_string(height) + " pixels, expected 1 to " +
                                    std::to_string(kMaxSide_px));
    }
    if (!(tone.exposure > 0.0)) throw std::invalid_argument("the exposure is not positive");
    std::vector<uint8_t> rgb;
    rgb.reserve(3 * static_cast<size_t>(width) * static_cast<size_t>(height));
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const std::array<uint8_t, 3> bytes = tone_mapped(pixel(x, y), tone);
            rgb.insert(rgb.end(), bytes.begin(), bytes.end());
        }
    }
    std::vector<std::byte> file;
    if (stbi_write_png_to_func(append, &file, width, height, 3, rgb.data(), 3 * width) == 0) {
        throw std::bad_alloc();
    }
    return file;
}

}  // namespace

std::array<uint8_t, 3> tone_mapped(const Rgb& color, const ToneCurve& tone) {
    return {tone_mapped_channel(static_cast<double>(color.r), tone),
            tone_mapped_channel(static_cast<double>(color.g), tone),
            tone_mapped_channel(static_cast<double>(color.b), tone)};
}

Rgb count_grey(double count, double white) {
    return Rgb(static_cast<float>(std::log(std::max(1.0, count)) / std::log(white)));
}

std::vector<std::byte> encode_image_png(const Image& image, const ToneCurve& tone) {
    return encode_png(image.width(), image.height(), tone,
                      [&](int x, int y) { return image.at(x, y); });
}

std::vector<std::byte> encode_cross_png(const Cubemap& cubemap, const ToneCurve& tone) {
    const int n = cubemap.face_size();
    return encode_png(4 * n, 3 * n, tone, [&](int x, int y) {
        for (const Place& place : kCross) {
            if (place.column == x / n && place.row == y / n) {
                return cubemap.at({place.face, x % n, y % n});
            }
        }
        return Rgb(0.0f);
    });
}

std::vector<std::byte> encode_panorama_png(const Cubemap& cubemap, int height_px,
                                           const ToneCurve& tone) {
    if (cubemap.image().empty()) throw std::invalid_argument("there is no preview of no cubemap");
    return encode_png(2 * height_px, height_px, tone, [&](int x, int y) {
        const double longitude = std::numbers::pi * (1.0 - (x + 0.5) / height_px);
        const double latitude = std::numbers::pi * (0.5 - (y + 0.5) / height_px);
        return sample_bilinear(cubemap,
                               {std::sin(longitude) * std::cos(latitude), std::sin(latitude),
                                std::cos(longitude) * std::cos(latitude)});
    });
}

}  // namespace probebake
