#include "scene/vox/vox_palette.h"

#include <algorithm>
#include <cmath>

namespace probebake {
namespace {

double srgb_to_linear(uint8_t byte) {
    const double c = byte / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

}  // namespace

VoxPalette default_vox_palette() {
    // The table of MagicaVoxel-file-format-vox.txt, section 8: the web-safe colours from white on,
    // red slowest, without black; then ten shades each of red, green, blue and grey.
    constexpr std::array<uint8_t, 10> kShades = {0xEE, 0xDD, 0xBB, 0xAA, 0x88,
                                                 0x77, 0x55, 0x44, 0x22, 0x11};
    VoxPalette palette{};
    size_t next = 1;
    for (int i = 215; i > 0; --i) {
        const auto level = [](int fifths) { return static_cast<uint8_t>(0x33 * fifths); };
        palette[next++] = {level(i / 36), level(i / 6 % 6), level(i % 6), 255};
    }
    for (const uint8_t s : kShades) palette[next++] = {s, 0, 0, 255};
    for (const uint8_t s : kShades) palette[next++] = {0, s, 0, 255};
    for (const uint8_t s : kShades) palette[next++] = {0, 0, s, 255};
    for (const uint8_t s : kShades) palette[next++] = {s, s, s, 255};
    return palette;
}

VoxColors linear_colors(const VoxPalette& palette, const VoxMaterials& materials) {
    VoxColors colors;
    std::array<Rgb, 256> radiance{};
    float brightest = 0.0f;
    for (size_t i = 1; i < 256; ++i) {
        const double strength = materials[i].emit * std::pow(10.0, materials[i].flux - 1.0);
        Rgb albedo;
        for (int c = 0; c < 3; ++c) {
            const double linear = srgb_to_linear(palette[i][static_cast<size_t>(c)]);
            albedo[c] = static_cast<float>(linear);
            radiance[i][c] = static_cast<float>(linear * strength);
            brightest = std::max(brightest, radiance[i][c]);
        }
        colors.albedo[i] = pack_rgb(albedo);
    }
    if (brightest > 0.0f) colors.emission_scale = std::ldexp(1.0f, std::ilogb(brightest) - 14);
    for (size_t i = 1; i < 256; ++i) {
        colors.emission[i] = pack_rgb(radiance[i] / colors.emission_scale);
    }
    return colors;
}

}  // namespace probebake
