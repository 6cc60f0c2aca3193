#include "image/exr.h"

#include <ImfChannelList.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>

#include "image/exr_attributes.h"
#include "image/exr_file.h"

namespace probebake {
namespace {

struct HalfRgb {
    Imath::half r, g, b;
};

std::string name_of(const CubePixel& pixel) {
    return "face " + std::string(kFaceNames[static_cast<size_t>(index_of(pixel.face))]) +
           ", pixel (" + std::to_string(pixel.x) + ", " + std::to_string(pixel.y) + ")";
}

[[noreturn]] void refuse(size_t index, int n, const char* channel, float value,
                         const char* expected) {
    throw std::domain_error(name_of(pixel_at(index, n)) + ", channel " + channel +
                            ": the value is " + std::to_string(value) + ", expected " + expected);
}

void check_radiance(const Cubemap& cubemap) {
    const auto pixels = cubemap.image().pixels();
    constexpr std::array kChannels = {"R", "G", "B"};
    for (size_t i = 0; i < pixels.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const float value = pixels[i][c];
            if (value >= 0.0f && std::isfinite(value)) continue;
            refuse(i, cubemap.face_size(), kChannels[static_cast<size_t>(c)], value,
                   "finite and not negative");
        }
    }
}

bool is_float_file(std::span<const Rgb> pixels) {
    return std::any_of(pixels.begin(), pixels.end(), [](const Rgb& c) {
        return c.r > kHalfMax || c.g > kHalfMax || c.b > kHalfMax;
    });
}

void check_edges(const Cubemap& cubemap) {
    for_each_shared_pixel(cubemap.face_size(), [&](const CubePixel& pixel, const CubePixel& owner) {
        if (cubemap.at(pixel) == cubemap.at(owner)) return;
        throw std::domain_error(name_of(pixel) + " differs from " + name_of(owner) +
                                ", which is the same direction");
    });
}

/// Interleaved red, green and blue that begin at `first`.
template <class Byte>
std::array<ExrChannel<Byte>, 3> rgb_channels(Byte* first, Imf::PixelType type) {
    const size_t bytes = type == Imf::HALF ? sizeof(Imath::half) : sizeof(float);
    return {ExrChannel<Byte>{"R", type, first, 3 * bytes},
            ExrChannel<Byte>{"G", type, first + bytes, 3 * bytes},
            ExrChannel<Byte>{"B", type, first + 2 * bytes, 3 * bytes}};
}

/// The members of an array of AuxPixel that begins at `first`.
template <class Byte>
std::array<ExrChannel<Byte>, 6> aux_channels(Byte* first) {
    const auto channel = [&](const char* name, Imf::PixelType type, size_t offset) {
        return ExrChannel<Byte>{name, type, first + offset, sizeof(AuxPixel)};
    };
    constexpr size_t kError = offsetof(AuxPixel, standard_error);
    return {channel("Z", Imf::FLOAT, offsetof(AuxPixel, z_m)),
            channel("Z2", Imf::FLOAT, offsetof(AuxPixel, z2_m2)),
            channel("stderr.R", Imf::FLOAT, kError),
            channel("stderr.G", Imf::FLOAT, kError + sizeof(float)),
            channel("stderr.B", Imf::FLOAT, kError + 2 * sizeof(float)),
            channel("samples", Imf::UINT, offsetof(AuxPixel, samples))};
}

void check_shape(const ExrReader& reader) {
    if (reader.height() == 6 * reader.width()) return;
    reader.fail("is " + std::to_string(reader.width()) + " x " + std::to_string(reader.height()) +
                ", expected six square faces in a column");
}

void check_aux(const CubeAux& aux) {
    constexpr std::array kChannels = {"Z", "Z2", "stderr.R", "stderr.G", "stderr.B"};
    for (size_t i = 0; i < aux.pixels.size(); ++i) {
        const AuxPixel& p = aux.pixels[i];
        const std::array values = {p.z_m, p.z2_m2, p.standard_error.r, p.standard_error.g,
                                   p.standard_error.b};
        for (size_t c = 0; c < values.size(); ++c) {
            if (values[c] >= 0.0f) continue;
            refuse(i, aux.face_size, kChannels[c], values[c], "not negative");
        }
    }
}

EncodedCubemap encode_rgb(const Imf::Header& header, std::span<const Rgb> pixels) {
    if (is_float_file(pixels)) {
        return {encode_exr(header, rgb_channels(std::as_bytes(pixels).data(), Imf::FLOAT)), true};
    }
    std::vector<HalfRgb> rounded;
    rounded.reserve(pixels.size());
    for (const Rgb& c : pixels) rounded.push_back({c.r, c.g, c.b});
    const auto bytes = std::as_bytes(std::span(rounded));
    return {encode_exr(header, rgb_channels(bytes.data(), Imf::HALF)), false};
}

/// Runs a check of values on what a file held.
template <class Check>
void check_read(const ExrReader& reader, const Check& check) {
    try {
        check();
    } catch (const std::domain_error& error) {
        reader.fail(error.what());
    }
}

}  // namespace

EncodedCubemap encode_cubemap(const Cubemap& cubemap, const ProbeAttributes& attributes) {
    const Imf::Header header = make_cube_header(cubemap.face_size(), attributes);
    check_radiance(cubemap);
    check_edges(cubemap);
    return encode_rgb(header, cubemap.image().pixels());
}

EncodedCubemap encode_layout(const Image& image, ExrLayout layout,
                             const ProbeAttributes& attributes) {
    std::optional<Imf::Envmap> envmap;
    if (layout == ExrLayout::kLatlong) envmap = Imf::ENVMAP_LATLONG;
    for (const Rgb& c : image.pixels()) {
        for (int i = 0; i < 3; ++i) {
            if (c[i] >= 0.0f && std::isfinite(c[i])) continue;
            throw std::domain_error("a value is " + std::to_string(c[i]) +
                                    ", expected finite and not negative");
        }
    }
    return encode_rgb(make_header(image.width(), image.height(), envmap, attributes),
                      image.pixels());
}

Cubemap rounded_to_file(const Cubemap& cubemap) {
    check_radiance(cubemap);
    Cubemap rounded = cubemap;
    if (is_float_file(cubemap.image().pixels())) return rounded;
    for (Rgb& c : rounded.image().pixels()) {
        c = {Imath::half(c.r), Imath::half(c.g), Imath::half(c.b)};
    }
    return rounded;
}

std::vector<std::byte> encode_aux(const CubeAux& aux, const ProbeAttributes& attributes) {
    const Imf::Header header = make_cube_header(aux.face_size, attributes);
    const size_t n = static_cast<size_t>(aux.face_size);
    if (aux.pixels.size() != 6 * n * n) {
        throw std::invalid_argument("an aux file of faces of " + std::to_string(n) +
                                    " pixels has " + std::to_string(6 * n * n) + " of them, not " +
                                    std::to_string(aux.pixels.size()));
    }
    check_aux(aux);
    return encode_exr(header, aux_channels(std::as_bytes(std::span(aux.pixels)).data()));
}

DecodedCubemap decode_cubemap(std::span<const std::byte> bytes, const std::string& file) {
    ExrReader reader(bytes, file, kMaxFaceSize_px, 6 * kMaxFaceSize_px);
    check_shape(reader);
    DecodedCubemap decoded{.attributes = read_cube_header(reader.header(), file)};
    decoded.cubemap = Cubemap(reader.width());
    const auto pixels = std::as_writable_bytes(decoded.cubemap.image().pixels());
    reader.read(rgb_channels(pixels.data(), Imf::FLOAT));
    decoded.is_float = reader.header().channels()["R"].type == Imf::FLOAT;
    check_read(reader, [&] { check_radiance(decoded.cubemap); });
    return decoded;
}

DecodedAux decode_aux(std::span<const std::byte> bytes, const std::string& file) {
    ExrReader reader(bytes, file, kMaxFaceSize_px, 6 * kMaxFaceSize_px);
    check_shape(reader);
    DecodedAux decoded{.attributes = read_cube_header(reader.header(), file)};
    const size_t n = static_cast<size_t>(reader.width());
    decoded.aux = {reader.width(), std::vector<AuxPixel>(6 * n * n)};
    reader.read(aux_channels(std::as_writable_bytes(std::span(decoded.aux.pixels)).data()));
    check_read(reader, [&] { check_aux(decoded.aux); });
    return decoded;
}

}  // namespace probebake
