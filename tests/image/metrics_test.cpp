#include "image/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "image/cubemaps.h"

namespace probebake {
namespace {

Cubemap constant(int n, const Rgb& value) {
    return test::make_cubemap(n, [&](const CubePixel&) { return value; });
}

TEST(Metrics, AnExactImageSaysSo) {
    const Cubemap cubemap = test::random_cubemap(16, 1);
    for (const Weighting weighting : {Weighting::kUniform, Weighting::kSolidAngle}) {
        const CubeError error = compare_cubemaps(cubemap, cubemap, 0.7, weighting);
        EXPECT_TRUE(error.cube.exact);
        EXPECT_EQ(error.cube.rmse, 0.0);
        EXPECT_EQ(error.cube.psnr_db, std::nullopt);
        EXPECT_EQ(error.cube.rel_mse, 0.0);
        ASSERT_TRUE(error.cube.ssim.has_value());
        EXPECT_NEAR(*error.cube.ssim, 1.0, 1e-12);
        for (const ImageError& face : error.faces) EXPECT_TRUE(face.exact);
    }
}

TEST(Metrics, TheSmallestDifferenceIsNotExact) {
    Cubemap cubemap(4);
    cubemap.at({CubeFace::kPosY, 1, 1}).g = std::numeric_limits<float>::denorm_min();
    const CubeError error = compare_cubemaps(cubemap, Cubemap(4), 1e9);
    EXPECT_FALSE(error.cube.exact);
    EXPECT_TRUE(error.faces[0].exact);
    EXPECT_FALSE(error.faces[2].exact);
    EXPECT_GT(*error.cube.psnr_db, 900.0);
}

TEST(Metrics, KnownValues) {
    // Error 0.1 in one of three channels, after an exposure of 2.
    const CubeError error = compare_cubemaps(constant(12, Rgb(1.0f, 0.5f, 0.5f)),
                                             constant(12, Rgb(0.8f, 0.5f, 0.5f)), 2.0);
    EXPECT_NEAR(error.cube.rmse, 0.1 / std::sqrt(3.0), 1e-8);
    EXPECT_NEAR(*error.cube.psnr_db, 20.0 + 10.0 * std::log10(3.0), 1e-6);
    const double mean = (0.4 + 0.25 + 0.25) / 3.0;
    EXPECT_NEAR(*error.cube.rel_mse, 0.01 / (0.16 + 0.01 * mean * mean) / 3.0, 1e-8);
    EXPECT_NEAR(error.faces[3].rmse, error.cube.rmse, 1e-15);
}

TEST(Metrics, RelativeErrorDoesNotDependOnTheExposure) {
    const Cubemap reference = test::wave_cubemap(16);
    const Cubemap image = test::with_noise(reference, 0.1, 5);
    const CubeError a = compare_cubemaps(image, reference, 1.0);
    const CubeError b = compare_cubemaps(image, reference, 250.0);
    EXPECT_NEAR(*a.cube.rel_mse, *b.cube.rel_mse, 1e-12);
    EXPECT_NEAR(a.cube.rmse, 250.0 * b.cube.rmse, 1e-12);
}

TEST(Metrics, ABlackReferenceHasNoRelativeError) {
    const CubeError error = compare_cubemaps(constant(4, Rgb(0.5f)), Cubemap(4), 1.0);
    EXPECT_EQ(error.cube.rel_mse, std::nullopt);
    EXPECT_NEAR(error.cube.rmse, 0.5, 1e-12);
    EXPECT_EQ(*compare_cubemaps(Cubemap(4), Cubemap(4), 1.0).cube.rel_mse, 0.0);
}

TEST(Metrics, SsimIsNotDefinedBelowElevenPixels) {
    for (const int n : {1, 2, 10, 11, 16}) {
        const CubeError error = compare_cubemaps(test::random_cubemap(n, 1), Cubemap(n), 1.0);
        EXPECT_EQ(error.cube.ssim.has_value(), n >= 11) << n;
        EXPECT_EQ(error.faces[5].ssim.has_value(), n >= 11) << n;
    }
}

TEST(Metrics, TheCubesFiguresAreMeansOfTheFaces) {
    const Cubemap reference = test::wave_cubemap(16);
    const Cubemap image = test::with_noise(reference, 0.1, 5);
    for (const Weighting weighting : {Weighting::kUniform, Weighting::kSolidAngle}) {
        const CubeError error = compare_cubemaps(image, reference, 1.3, weighting);
        double mse = 0.0;
        double ssim = 0.0;
        for (const ImageError& face : error.faces) {
            mse += face.rmse * face.rmse / 6.0;
            ssim += *face.ssim / 6.0;
        }
        EXPECT_NEAR(error.cube.rmse, std::sqrt(mse), 1e-12);
        EXPECT_NEAR(*error.cube.ssim, ssim, 1e-12);
        EXPECT_NEAR(*error.cube.psnr_db, -20.0 * std::log10(error.cube.rmse), 1e-9);
    }
}

TEST(Metrics, WeightsAreThoseOfStoredPixelsOrOfDirections) {
    // One wrong corner: it is stored three times; its three clipped cells count once each.
    const int n = 16;
    Cubemap image(n);
    image.at({CubeFace::kPosX, 0, 0}) = Rgb(1.0f);
    image.share_edges();
    const double uniform = compare_cubemaps(image, Cubemap(n), 1.0).cube.rmse;
    EXPECT_NEAR(uniform * uniform, 3.0 / (6.0 * n * n), 1e-12);
    const double weighted =
        compare_cubemaps(image, Cubemap(n), 1.0, Weighting::kSolidAngle).cube.rmse;
    EXPECT_NEAR(weighted * weighted, 3.0 * pixel_solid_angle(0, 0, n) / (4.0 * std::numbers::pi),
                1e-12);
    EXPECT_LT(weighted, 0.5 * uniform);
}

TEST(Metrics, SolidAnglesWeighTheWindowsOfSsim) {
    // Wrong in the middle of each face only, where a pixel covers most of the sphere.
    const int n = 33;
    const Cubemap reference = test::wave_cubemap(n);
    Cubemap image = reference;
    for (const CubeFace face : kCubeFaces) image.at({face, n / 2, n / 2}) += Rgb(0.3f);
    const double uniform = *compare_cubemaps(image, reference, 1.0).cube.ssim;
    const double weighted =
        *compare_cubemaps(image, reference, 1.0, Weighting::kSolidAngle).cube.ssim;
    EXPECT_LT(weighted, uniform - 0.001);
}

TEST(Metrics, ImagesOfAnyShapeAreCompared) {
    Image a(20, 13);
    Image r(20, 13);
    for (Rgb& c : r.pixels()) c = Rgb(0.5f);
    const ImageError error = compare_images(a, r, 1.0);
    EXPECT_NEAR(error.rmse, 0.5, 1e-12);
    EXPECT_NEAR(*error.ssim, 0.0001 / 0.2501, 1e-7);
    EXPECT_NEAR(*error.rel_mse, 1.0 / 1.01, 1e-7);
}

TEST(Metrics, RefusesWhatCannotBeCompared) {
    const Cubemap four(4);
    EXPECT_THROW(compare_cubemaps(four, Cubemap(5), 1.0), std::invalid_argument);
    EXPECT_THROW(compare_cubemaps(Cubemap(), Cubemap(), 1.0), std::invalid_argument);
    EXPECT_THROW(compare_images(Image(3, 4), Image(4, 3), 1.0), std::invalid_argument);
    for (const double exposure : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
        EXPECT_THROW(compare_cubemaps(four, four, exposure), std::invalid_argument);
    }
}

TEST(Metrics, NaNIsNeverAGoodFigure) {
    Cubemap image(16);
    image.at({CubeFace::kPosZ, 8, 8}).r = std::nanf("");
    const CubeError error = compare_cubemaps(image, Cubemap(16), 1.0);
    EXPECT_TRUE(std::isnan(error.cube.rmse));
    EXPECT_FALSE(error.cube.exact);
    EXPECT_TRUE(std::isnan(*error.cube.psnr_db));
    EXPECT_TRUE(std::isnan(*error.cube.ssim));
    EXPECT_TRUE(error.faces[0].exact);
}

}  // namespace
}  // namespace probebake
