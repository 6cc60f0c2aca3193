#include "light/sky_file.h"

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <gtest/gtest.h>

#include <cmath>

#include "image/exr_file.h"
#include "io/file.h"
#include "io/io_error.h"
#include "light/sky_light.h"
#include "support/data.h"

namespace probebake {
namespace {

std::vector<std::byte> exr_picture(int width, int height, float red) {
    std::vector<Rgb> pixels(static_cast<size_t>(width * height), Rgb(1.0f, 2.0f, 4.0f));
    pixels[static_cast<size_t>(width + 1)].r = red;
    const auto* first = reinterpret_cast<const std::byte*>(pixels.data());
    const ExrChannel<const std::byte> channels[] = {
        {"R", Imf::FLOAT, first, sizeof(Rgb)},
        {"G", Imf::FLOAT, first + sizeof(float), sizeof(Rgb)},
        {"B", Imf::FLOAT, first + 2 * sizeof(float), sizeof(Rgb)}};
    return encode_exr(Imf::Header(width, height), channels);
}

TEST(SkyFile, ReadsOpenExr) {
    const auto image = decode_sky(exr_picture(8, 4, 7.0f), "sky.exr");
    EXPECT_EQ(image->width(), 8);
    EXPECT_EQ(image->at(0, 0), Rgb(1.0f, 2.0f, 4.0f));
    EXPECT_EQ(image->at(1, 1), Rgb(7.0f, 2.0f, 4.0f));
}

TEST(SkyFile, RefusesWhatIsNoSkyAndNamesTheFileOnly) {
    const auto refused = [](std::span<const std::byte> bytes, const std::string& why) {
        try {
            decode_sky(bytes, "sky.exr");
            ADD_FAILURE() << why;
        } catch (const IoError& error) {
            EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
        }
    };
    refused({}, "neither");
    refused(exr_picture(8, 8, 1.0f), "twice as wide as high");
    refused(exr_picture(8, 4, -1.0f), "1, 1 is negative");
    refused(exr_picture(8, 4, std::nanf("")), "not finite");
    refused(exr_picture(8, 4, INFINITY), "not finite");
    const std::vector<std::byte> whole = exr_picture(8, 4, 1.0f);
    refused(std::span(whole).first(whole.size() - 10), "sky.exr");
    try {
        read_sky_file("/no/such/folder/sky.hdr");
        ADD_FAILURE();
    } catch (const IoError& error) {
        EXPECT_EQ(std::string(error.what()).find("folder/"), std::string::npos);
    }
}

/// A sunrise over the sea (MANIFEST: hdr), as .hdr and as .exr of half precision.
TEST(SkyFile, TheRealSkyIsTheSameInBothFormats) {
    const auto hdr_path = test::data_file("hdr/blouberg_sunrise_2_1k.hdr");
    const auto exr_path = test::data_file("hdr/blouberg_sunrise_2_1k.exr");
    if (!hdr_path || !exr_path) GTEST_SKIP() << "no hdr/ in PROBEBAKE_DATA";
    const auto hdr = read_sky_file(*hdr_path).image;
    const auto exr = read_sky_file(*exr_path).image;
    ASSERT_EQ(hdr->width(), 1024);
    ASSERT_EQ(hdr->height(), 512);
    Rgb largest(0.0f);
    for (size_t i = 0; i < hdr->pixels().size(); ++i) {
        const Rgb& a = hdr->pixels()[i];
        const Rgb& b = exr->pixels()[i];
        largest = glm::max(largest, a);
        // The .exr was made by a reader that adds half a step to every mantissa (Radiance's own);
        // the largest of the three mantissas has 128 steps at least.
        const float step = std::max({a.r, a.g, a.b}) / 128.0f;
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(b[c] - a[c], 0.5f * step, 0.51f * step) << i;
    }
    EXPECT_EQ(largest, Rgb(50.5f, 35.5f, 12.0f));  // as `iinfo --stats` says
    // The sky is above, the land below: more light falls on what faces up.
    const SkyLight light(Sky(SkyPicture{hdr, 1.0}), 64);
    EXPECT_GT(luminance(Rgb(light.irradiance(CubeFace::kPosY))),
              1.5f * luminance(Rgb(light.irradiance(CubeFace::kNegY))));
}

}  // namespace
}  // namespace probebake
