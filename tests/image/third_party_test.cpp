// What other programs say of our files and figures. A test skips where its program is missing.
#include <ImfEnvmap.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "image/cubemaps.h"
#include "image/exr.h"
#include "image/metrics.h"
#include "image/rgb_file.h"
#include "image/tools.h"
#include "io/file.h"

namespace probebake {
namespace {

using test::number_after;
using test::run_tool;

#define SKIP_WITHOUT(tool) \
    if (!test::has_tool(tool)) GTEST_SKIP() << (tool) << " is not installed"

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

class ThirdParty : public testing::Test {
  protected:
    std::string write(const std::string& name, std::span<const std::byte> bytes) const {
        write_file_atomically(folder_ / name, bytes);
        return (folder_ / name).string();
    }
    std::string write(const std::string& name, const Cubemap& cubemap,
                      const ProbeAttributes& attributes = {}) const {
        return write(name, encode_cubemap(cubemap, attributes).bytes);
    }

    test::TemporaryFolder folder_;
};

ProbeAttributes some_attributes() {
    ProbeAttributes attributes;
    attributes.owner = "somebody";
    attributes.id = "p7";
    attributes.state = "noon";
    attributes.position_m = {12.345678901234567, 0.1, -300.0};
    attributes.seed = 18446744073709551615u;
    attributes.numbers["probe:err:rmse"] = 0.0123;
    attributes.texts["probe:err:against"] = "truth";
    return attributes;
}

TEST_F(ThirdParty, ExrheaderShowsACubeAndItsAttributes) {
    SKIP_WITHOUT("exrheader");
    const auto shown =
        run_tool("exrheader " + write("cube.exr", test::random_cubemap(16, 1), some_attributes()));
    ASSERT_EQ(shown.status, 0) << shown.text;
    for (const char* line :
         {"envmap (type envmap): cube-face map", "R, 16-bit floating-point, sampling 1 1",
          "compression (type compression): zip, multi-scanline blocks",
          "dataWindow (type box2i): (0 0) - (15 95)", "type (type string): \"scanlineimage\"",
          "red   (0.64 0.33)", "owner (type string): \"somebody\"",
          "probe:id (type string): \"p7\"",
          "probe:position (type string): \"12.345678901234567 0.1 -300\"",
          "probe:near (type double): 0", "probe:far (type double): inf",
          "probe:unit (type string): \"W.m^-2.sr^-1\"",
          "probe:seed (type string): \"18446744073709551615\"", "probe:valid (type int): 1",
          "probe:err:rmse (type double): 0.0123", "probe:err:against (type string): \"truth\""}) {
        EXPECT_TRUE(contains(shown.text, line)) << line << "\nnot in\n" << shown.text;
    }
    Cubemap bright = test::random_cubemap(16, 1);
    bright.at({CubeFace::kPosX, 5, 5}).r = 1e6f;
    const auto float_file = run_tool("exrheader " + write("float.exr", bright));
    EXPECT_TRUE(contains(float_file.text, "R, 32-bit floating-point")) << float_file.text;
    EXPECT_FALSE(contains(float_file.text, "16-bit")) << float_file.text;
}

TEST_F(ThirdParty, ExrheaderShowsTheAuxChannels) {
    SKIP_WITHOUT("exrheader");
    const CubeAux aux{4, std::vector<AuxPixel>(96)};
    const auto shown = run_tool("exrheader " + write("aux.exr", encode_aux(aux, {})));
    for (const char* line : {"Z, 32-bit floating-point", "Z2, 32-bit floating-point",
                             "stderr.R, 32-bit floating-point", "stderr.G, 32-bit floating-point",
                             "stderr.B, 32-bit floating-point", "samples, 32-bit unsigned integer",
                             "envmap (type envmap): cube-face map"}) {
        EXPECT_TRUE(contains(shown.text, line)) << line << "\nnot in\n" << shown.text;
    }
}

TEST_F(ThirdParty, IinfoSeesACubeWithSharedEdges) {
    SKIP_WITHOUT("iinfo");
    const auto shown = run_tool("iinfo -v " + write("cube.exr", test::random_cubemap(16, 1)));
    ASSERT_EQ(shown.status, 0) << shown.text;
    for (const char* part : {"  16 x   96, 3 channel, half openexr", "channel list: R, G, B",
                             "CubeFace Environment", "oiio:sampleborder: 1"}) {
        EXPECT_TRUE(contains(shown.text, part)) << part << "\nnot in\n" << shown.text;
    }
}

/// Largest angle (degrees) between where a pixel of a latlong map is and where its value points.
double largest_angle(const Image& latlong) {
    const Imath::Box2i window({0, 0}, {latlong.width() - 1, latlong.height() - 1});
    double largest = 0.0;
    for (int y = 0; y < latlong.height(); ++y) {
        for (int x = 0; x < latlong.width(); ++x) {
            const Imath::V3f there =
                Imf::LatLongMap::direction(window, {static_cast<float>(x), static_cast<float>(y)});
            const Vec3 d = glm::normalize(Vec3(there.x, there.y, there.z));
            const Vec3 value = glm::normalize(2.0 * Vec3(latlong.at(x, y)) - 1.0);
            // The chord is exact for small angles, where the cosine is not.
            const double chord = glm::length(value - d);
            largest = std::max(largest, 2.0 * std::asin(std::min(chord / 2.0, 1.0)));
        }
    }
    return largest * 180.0 / std::numbers::pi;
}

class ExrenvmapTest : public ThirdParty {
  protected:
    Image latlong_of(const Cubemap& cubemap, int width) const {
        const std::string latlong = (folder_ / "latlong.exr").string();
        const auto run = run_tool("exrenvmap -l -w " + std::to_string(width) + " " +
                                  write("cube.exr", cubemap) + " " + latlong);
        EXPECT_EQ(run.status, 0) << run.text;
        return test::read_rgb_file(latlong);
    }
};

// Rounding 0.5 + 0.5 d to HALF turns a direction by up to 0.045 degrees, and exrenvmap rounds once
// more. With many pixels for each of the result's the first rounding averages out.
TEST_F(ExrenvmapTest, FindsEveryDirectionInAFineCube) {
    SKIP_WITHOUT("exrenvmap");
    const double angle = largest_angle(latlong_of(test::direction_cubemap(256), 64));
    std::printf("N = 256 at width 64: largest angle %.4f degrees\n", angle);
    EXPECT_LT(angle, 0.05);
}

// The mean over cubes of different brightness, whose values round differently.
TEST_F(ExrenvmapTest, FindsEveryDirectionWhereWeRenderedIt) {
    SKIP_WITHOUT("exrenvmap");
    const Cubemap cubemap = test::direction_cubemap(64);
    const int width = 128;
    constexpr int kCubes = 5;
    Image mean(width, width / 2);
    for (int i = 0; i < kCubes; ++i) {
        const float brightness = std::exp2(static_cast<float>(i) / kCubes);
        Cubemap brighter = cubemap;
        for (Rgb& c : brighter.image().pixels()) c *= brightness;
        const Image latlong = latlong_of(brighter, width);
        if (i == 0) {
            const double angle = largest_angle(latlong);
            std::printf("N = 64 at width 128, one cube: largest angle %.4f degrees\n", angle);
            EXPECT_LT(angle, 0.09);
        }
        for (size_t p = 0; p < mean.pixels().size(); ++p) {
            mean.pixels()[p] += latlong.pixels()[p] / (brightness * kCubes);
        }
    }
    const double angle = largest_angle(mean);
    std::printf("N = 64 at width 128, %d cubes: largest angle %.4f degrees\n", kCubes, angle);
    EXPECT_LT(angle, 0.05);
}

TEST_F(ExrenvmapTest, ShowsThatTexelCentresWouldBeWrong) {
    SKIP_WITHOUT("exrenvmap");
    const int n = 64;
    Cubemap centres(n);
    for (const CubeFace face : kCubeFaces) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                const Vec3 d =
                    face_direction(face, (2.0 * x + 1.0) / n - 1.0, (2.0 * y + 1.0) / n - 1.0);
                centres.at({face, x, y}) = Rgb(0.5 + 0.5 * glm::normalize(d));
            }
        }
    }
    // Our writer refuses such data, as its edges differ; shared, they are still off.
    EXPECT_THROW(encode_cubemap(centres, {}), std::domain_error);
    centres.share_edges();
    EXPECT_GT(largest_angle(latlong_of(centres, 128)), 0.4);
}

TEST_F(ThirdParty, OiiotoolAgreesOnRmseAndPsnr) {
    SKIP_WITHOUT("oiiotool");
    const Cubemap reference = rounded_to_file(test::wave_cubemap(32));
    const Cubemap image = rounded_to_file(test::with_noise(reference, 0.03, 6));
    const auto shown = run_tool("oiiotool --diff " + write("reference.exr", reference) + " " +
                                write("image.exr", image));
    const ImageError error = compare_cubemaps(image, reference, 1.0).cube;
    EXPECT_NEAR(number_after(shown.text, "RMS error = "), error.rmse, 1e-6 * error.rmse)
        << shown.text;
    // Its peak is the largest value of either image, where that exceeds 1.
    double peak = 1.0;
    for (const auto& pixels : {image.image().pixels(), reference.image().pixels()}) {
        for (const Rgb& c : pixels) {
            peak = std::max({peak, double(c.r), double(c.g), double(c.b)});
        }
    }
    EXPECT_NEAR(number_after(shown.text, "Peak SNR = ") - 20.0 * std::log10(peak), *error.psnr_db,
                1e-4)
        << shown.text;
}

class NumpyTest : public ThirdParty {
  protected:
    std::string raw(const std::string& name, std::span<const Rgb> pixels) const {
        return write(name, std::as_bytes(pixels));
    }
    std::string figures(std::span<const Rgb> image, std::span<const Rgb> reference, int width,
                        double exposure) const {
        const auto shown =
            run_tool("/usr/bin/python3 " PROBEBAKE_SOURCE_DIR "/tests/image/metrics.py " +
                     raw("image", image) + " " + raw("reference", reference) + " " +
                     std::to_string(width) + " " + std::to_string(exposure));
        EXPECT_EQ(shown.status, 0) << shown.text;
        return shown.text;
    }
};

TEST_F(NumpyTest, NumpyAndScikitImageAgreeOnEveryFigure) {
    if (run_tool("/usr/bin/python3 -c 'import skimage.metrics'").status != 0) {
        GTEST_SKIP() << "python3-skimage is not installed";
    }
    const int n = 48;
    const double exposure = 0.75;  // so that some of the luminance is clipped
    const Cubemap reference = test::wave_cubemap(n);
    const Cubemap image = test::with_noise(reference, 0.06, 6);
    const CubeError error = compare_cubemaps(image, reference, exposure);
    const auto agree = [&](const ImageError& ours, const std::string& theirs) {
        EXPECT_NEAR(number_after(theirs, "rmse "), ours.rmse, 1e-9) << theirs;
        EXPECT_NEAR(number_after(theirs, "psnr "), *ours.psnr_db, 1e-7) << theirs;
        EXPECT_NEAR(number_after(theirs, "rel_mse "), *ours.rel_mse, 1e-9) << theirs;
    };
    const size_t f = 3;
    const size_t face = static_cast<size_t>(n) * static_cast<size_t>(n);
    const std::string theirs =
        figures(image.image().pixels().subspan(f * face, face),
                reference.image().pixels().subspan(f * face, face), n, exposure);
    agree(error.faces[f], theirs);
    EXPECT_NEAR(number_after(theirs, "ssim "), *error.faces[f].ssim, 1e-9) << theirs;
    std::printf("face %s: SSIM %.9f\n%s", kFaceNames[f], *error.faces[f].ssim, theirs.c_str());
    // The whole column at once, where windows of SSIM may straddle faces: an image, not a cube.
    const std::string column =
        figures(image.image().pixels(), reference.image().pixels(), n, exposure);
    const ImageError ours = compare_images(image.image(), reference.image(), exposure);
    agree(error.cube, column);
    agree(ours, column);
    EXPECT_NEAR(number_after(column, "ssim "), *ours.ssim, 1e-9) << column;
}

}  // namespace
}  // namespace probebake
