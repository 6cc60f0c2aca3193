// Colours and emission of .vox files.
#include "scene/vox/vox_palette.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scene/vox/vox_import.h"
#include "scene/vox_writer.h"

namespace probebake {
namespace {

using test::VoxWriter;

/// Half a step of the nine bits of a packed component, relative to the largest.
constexpr float kHalfStep = 1.0f / 511.0f;

VoxPalette gray_palette(uint8_t value) {
    VoxPalette palette{};
    palette.fill({value, value, value, 255});
    return palette;
}

TEST(VoxPalette, DefaultIsTheDocumentedTable) {
    const VoxPalette palette = default_vox_palette();
    const auto is = [&](size_t i, int r, int g, int b) {
        return palette[i] == std::array<uint8_t, 4>{static_cast<uint8_t>(r),
                                                    static_cast<uint8_t>(g),
                                                    static_cast<uint8_t>(b), 255};
    };
    EXPECT_TRUE(is(1, 255, 255, 255));
    EXPECT_TRUE(is(2, 255, 255, 0xCC));
    EXPECT_TRUE(is(7, 255, 0xCC, 255));
    EXPECT_TRUE(is(37, 0xCC, 255, 255));
    EXPECT_TRUE(is(215, 0, 0, 0x33));
    EXPECT_TRUE(is(216, 0xEE, 0, 0));
    EXPECT_TRUE(is(226, 0, 0xEE, 0));
    EXPECT_TRUE(is(236, 0, 0, 0xEE));
    EXPECT_TRUE(is(255, 0x11, 0x11, 0x11));
    // FNV-1a over the bytes of entries 1 to 255 of the table in the format's documentation.
    uint64_t hash = 0xCBF2'9CE4'8422'2325;
    for (size_t i = 1; i < 256; ++i) {
        for (const uint8_t byte : palette[i]) hash = (hash ^ byte) * 0x100'0000'01B3;
    }
    EXPECT_EQ(hash, 0xEEA2'FF5B'2556'D55Cu);
}

TEST(VoxPalette, UsesTheExactSrgbCurve) {
    // IEC 61966-2-1; a pure power of 2.2 is off by 40 % at 10 and by 1.4 % at 128.
    const std::pair<uint8_t, float> samples[] = {
        {0, 0.0f},          {1, 0.000303527f},  {10, 0.003035270f}, {11, 0.003346536f},
        {51, 0.033104767f}, {128, 0.21586050f}, {255, 1.0f}};
    for (const auto& [byte, linear] : samples) {
        const VoxColors colors = linear_colors(gray_palette(byte), {});
        const Rgb albedo = unpack_rgb(colors.albedo[77]);
        EXPECT_NEAR(albedo.g, linear, linear * kHalfStep) << int{byte};
        EXPECT_EQ(albedo.r, albedo.b);
    }
}

TEST(VoxPalette, RadianceIsColorTimesEmissionTimesDecadesOfPower) {
    VoxPalette palette = gray_palette(255);
    palette[2] = {255, 128, 0, 255};
    VoxMaterials materials{};
    materials[1] = {.emit = 1.0, .flux = 1.0};
    materials[2] = {.emit = 0.5, .flux = 3.0};
    materials[3] = {.emit = 1.0, .flux = 0.0};
    const VoxColors colors = linear_colors(palette, materials);
    const auto radiance = [&](size_t i) {
        return unpack_rgb(colors.emission[i]) * colors.emission_scale;
    };
    EXPECT_NEAR(radiance(1).r, 1.0f, kHalfStep);
    EXPECT_NEAR(radiance(2).r, 50.0f, 50.0f * kHalfStep);
    EXPECT_NEAR(radiance(2).g, 50.0f * 0.2158605f, 50.0f * kHalfStep);
    EXPECT_EQ(radiance(2).b, 0.0f);
    EXPECT_NEAR(radiance(3).r, 0.1f, 0.1f * kHalfStep);
    EXPECT_EQ(colors.emission[4], 0u);
}

TEST(VoxPalette, EmissionScaleIsAPowerOfTwoThatFitsAnyPower) {
    for (double flux = 0.0; flux <= kMaxVoxFlux; flux += 0.5) {
        for (const double emit : {1e-6, 0.3, kMaxVoxEmit}) {
            VoxMaterials materials{};
            materials[9] = {.emit = emit, .flux = flux};
            const VoxColors colors = linear_colors(gray_palette(255), materials);
            int exponent = 0;
            EXPECT_EQ(std::frexp(colors.emission_scale, &exponent), 0.5f);
            const auto expected = static_cast<float>(emit * std::pow(10.0, flux - 1.0));
            EXPECT_NEAR(unpack_rgb(colors.emission[9]).g * colors.emission_scale, expected,
                        expected * kHalfStep);
        }
    }
    EXPECT_EQ(linear_colors(gray_palette(255), {}).emission_scale, 1.0f);
}

/// Emission of a white voxel of colour 1 in a file with that material.
float imported_emission(int id, const test::Pairs& properties) {
    const VoxImport result = import_vox(
        VoxWriter().model({1, 1, 1}, {{0, 0, 0, 1}}).material(id, properties).file(), "test.vox");
    EXPECT_EQ(result.emissive_voxels, result.cloud.voxels.at(0).emission != 0 ? 1u : 0u);
    return unpack_rgb(result.cloud.voxels.at(0).emission).g * result.cloud.emission_scale;
}

TEST(VoxPalette, ReadsEmissiveMaterials) {
    EXPECT_NEAR(imported_emission(1, {{"_type", "_emit"}, {"_emit", "0.38"}, {"_flux", "3"}}),
                38.0f, 38.0f * kHalfStep);
    // The camera's darkening does not change what an emitter lights.
    EXPECT_NEAR(
        imported_emission(1, {{"_type", "_emit"}, {"_emit", "1"}, {"_flux", "1"}, {"_ldr", "0.8"}}),
        1.0f, kHalfStep);
    // Early files have the emission in _weight.
    EXPECT_NEAR(imported_emission(1, {{"_type", "_emit"}, {"_weight", "0.5"}, {"_flux", "1"}}),
                0.5f, 0.5f * kHalfStep);
    EXPECT_NEAR(imported_emission(1, {{"_type", "_emit"}, {"_emit", "1"}}), 0.1f, 0.1f * kHalfStep);
    EXPECT_EQ(imported_emission(1, {{"_type", "_emit"}}), 0.0f);
}

TEST(VoxPalette, IgnoresWhatDoesNotShine) {
    // The editor keeps the numbers of a type that was chosen before.
    EXPECT_EQ(imported_emission(1, {{"_type", "_diffuse"}, {"_emit", "1"}, {"_flux", "4"}}), 0.0f);
    EXPECT_EQ(imported_emission(1, {{"_emit", "1"}, {"_flux", "4"}}), 0.0f);
    EXPECT_EQ(imported_emission(2, {{"_type", "_emit"}, {"_emit", "1"}, {"_flux", "4"}}), 0.0f);
    EXPECT_EQ(imported_emission(256, {{"_type", "_emit"}, {"_emit", "1"}, {"_flux", "4"}}), 0.0f);
}

TEST(VoxPalette, SaysThatOtherMaterialsAreTakenAsDiffuse) {
    VoxWriter writer;
    writer.model({1, 1, 1}, {{0, 0, 0, 1}});
    writer.material(1, {{"_type", "_glass"}}).material(2, {{"_type", "_metal"}});
    EXPECT_EQ(
        import_vox(writer.file(), "test.vox").warnings,
        std::vector<std::string>{"materials other than _diffuse and _emit are taken as diffuse"});
}

}  // namespace
}  // namespace probebake
