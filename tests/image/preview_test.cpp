#include "image/preview.h"

#include <ImfEnvmap.h>
#include <gtest/gtest.h>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#include <stb/stb_image.h>

#include <memory>
#include <numbers>
#include <stdexcept>

#include "image/cubemaps.h"

namespace probebake {
namespace {

using Bytes3 = std::array<uint8_t, 3>;

struct Picture {
    int width = 0;
    int height = 0;
    std::vector<uint8_t> rgb;

    Bytes3 at(int x, int y) const {
        const size_t i = 3 * (static_cast<size_t>(y) * static_cast<size_t>(width) + size_t(x));
        return {rgb[i], rgb[i + 1], rgb[i + 2]};
    }
};

Picture decode(const std::vector<std::byte>& png) {
    Picture picture;
    int channels = 0;
    const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> data(
        stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(png.data()),
                              static_cast<int>(png.size()), &picture.width, &picture.height,
                              &channels, 0),
        &stbi_image_free);
    EXPECT_NE(data, nullptr);
    EXPECT_EQ(channels, 3);
    const size_t count = 3 * size_t(picture.width) * size_t(picture.height);
    picture.rgb.assign(data.get(), data.get() + count);
    return picture;
}

TEST(Preview, KnownColours) {
    // sRGB codes of IEC 61966-2-1: 0.18 is 118, 0.5 is 188 (187.5), the linear foot ends at 10.
    EXPECT_EQ(tone_mapped(Rgb(0.0f, 0.18f, 1.0f), {}), (Bytes3{0, 118, 255}));
    EXPECT_EQ(tone_mapped(Rgb(0.5f, 0.0031308f, 7.0f), {}), (Bytes3{188, 10, 255}));
    EXPECT_EQ(tone_mapped(Rgb(36.0f, 100.0f, 200.0f), {.exposure = 200.0}),
              (Bytes3{118, 188, 255}));
    const float nan = std::nanf("");
    EXPECT_EQ(tone_mapped(Rgb(nan, -1.0f, HUGE_VALF), {}), (Bytes3{0, 0, 255}));
}

TEST(Preview, TheShoulderLeavesDarkColoursAloneAndKeepsBrightOnesApart) {
    const ToneCurve tone{.exposure = 1.0, .shoulder = true};
    EXPECT_EQ(tone_mapped(Rgb(0.0f, 0.18f, 0.5f), tone), (Bytes3{0, 118, 188}));
    // 0.6 + 0.4 (1 − e^−1) = 0.852848 at 1, sRGB 0.931694.
    EXPECT_EQ(tone_mapped(Rgb(1.0f), tone)[0], 238);
    int previous = -1;
    for (const float x : {0.1f, 0.59f, 0.61f, 0.8f, 1.0f, 1.5f, 2.0f}) {
        const int code = tone_mapped(Rgb(x), tone)[0];
        EXPECT_GT(code, previous) << x;
        EXPECT_LT(code, 255) << x;
        previous = code;
    }
    EXPECT_EQ(tone_mapped(Rgb(HUGE_VALF), tone)[0], 255);
}

TEST(Preview, CrossShowsEveryFaceInItsPlace) {
    const int n = 8;
    const Cubemap cubemap = test::make_cubemap(n, [](const CubePixel& p) {
        const auto bit = [&](int i) {
            return ((index_of(p.face) + 1) >> i & 1) != 0 ? 1.0f : 0.0f;
        };
        return Rgb(bit(0), bit(1), bit(2));
    });
    const Picture cross = decode(encode_cross_png(cubemap, {}));
    ASSERT_EQ(cross.width, 4 * n);
    ASSERT_EQ(cross.height, 3 * n);
    // Index of the face, plus one; 0 is black.
    const int expected[3][4] = {{0, 3, 0, 0}, {2, 6, 1, 5}, {0, 4, 0, 0}};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
            const Bytes3 c = cross.at(column * n + n / 2, row * n + n / 2);
            const int code = (c[0] != 0 ? 1 : 0) + (c[1] != 0 ? 2 : 0) + (c[2] != 0 ? 4 : 0);
            EXPECT_EQ(code, expected[row][column]) << row << " " << column;
        }
    }
}

TEST(Preview, CrossIsContinuousWhereFacesMeet) {
    const int n = 16;
    const Picture cross = decode(encode_cross_png(test::direction_cubemap(n), {}));
    for (int i = 0; i < n; ++i) {
        for (int column = 1; column < 4; ++column) {
            EXPECT_EQ(cross.at(column * n - 1, n + i), cross.at(column * n, n + i)) << column;
        }
        EXPECT_EQ(cross.at(4 * n - 1, n + i), cross.at(0, n + i));
        EXPECT_EQ(cross.at(n + i, n - 1), cross.at(n + i, n));
        EXPECT_EQ(cross.at(n + i, 2 * n - 1), cross.at(n + i, 2 * n));
    }
    // Up is +Y, and +X is to the right of −Z.
    EXPECT_GT(cross.at(n + n / 2, n + 2)[1], cross.at(n + n / 2, 2 * n - 3)[1]);
    EXPECT_GT(cross.at(2 * n - 3, n + n / 2)[0], cross.at(n + 2, n + n / 2)[0]);
}

TEST(Preview, PanoramaHasOpenExrsLongitudes) {
    const int height = 64;
    const Picture panorama = decode(encode_panorama_png(test::direction_cubemap(64), height, {}));
    ASSERT_EQ(panorama.width, 2 * height);
    ASSERT_EQ(panorama.height, height);
    // OpenEXR's latlong has pixel centres on the border: ours are its positions 0.5, 1.5, ...
    const Imath::Box2i window({0, 0}, {2 * height, height});
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < 2 * height; ++x) {
            const Imath::V3f d = Imf::LatLongMap::direction(
                window, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
            const Bytes3 expected =
                tone_mapped(Rgb(0.5f + 0.5f * d.x, 0.5f + 0.5f * d.y, 0.5f + 0.5f * d.z), {});
            const Bytes3 shown = panorama.at(x, y);
            for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(shown[c], expected[c], 1) << x << " " << y;
        }
    }
}

TEST(Preview, TheSameInputGivesTheSameBytes) {
    const Cubemap cubemap = test::random_cubemap(16, 3);
    EXPECT_EQ(encode_cross_png(cubemap, {}), encode_cross_png(cubemap, {}));
    EXPECT_EQ(encode_panorama_png(cubemap, 9, {}), encode_panorama_png(cubemap, 9, {}));
}

TEST(Preview, RefusesWhatCannotBeShown) {
    const Cubemap cubemap(4);
    EXPECT_THROW(encode_cross_png(Cubemap(), {}), std::invalid_argument);
    EXPECT_THROW(encode_panorama_png(Cubemap(), 64, {}), std::invalid_argument);
    EXPECT_THROW(encode_panorama_png(cubemap, 0, {}), std::invalid_argument);
    EXPECT_THROW(encode_panorama_png(cubemap, 9000, {}), std::invalid_argument);
    EXPECT_THROW(encode_cross_png(cubemap, {.exposure = 0.0}), std::invalid_argument);
    EXPECT_THROW(encode_cross_png(cubemap, {.exposure = std::nan("")}), std::invalid_argument);
}

TEST(CountGrey, IsLogarithmicFromOneToWhite) {
    EXPECT_EQ(count_grey(0.0, 256.0).r, 0.0f);
    EXPECT_EQ(count_grey(1.0, 256.0).r, 0.0f);
    EXPECT_FLOAT_EQ(count_grey(16.0, 256.0).g, 0.5f);
    EXPECT_FLOAT_EQ(count_grey(256.0, 256.0).b, 1.0f);
}

}  // namespace
}  // namespace probebake
