#include "image/exposure.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <vector>

namespace probebake {
namespace {

/// Grey pixels 1, 2, ... n, not in order.
std::vector<Rgb> ramp(int n) {
    std::vector<Rgb> pixels;
    pixels.reserve(static_cast<size_t>(n));
    for (int i = 0; i < n; ++i) pixels.emplace_back(static_cast<float>(1 + (i * 37) % n));
    return pixels;
}

TEST(Exposure, IsTheNearestRankOfThe99thPercentile) {
    EXPECT_NEAR(exposure_of(ramp(1)), 1.0, 1e-6);
    EXPECT_NEAR(exposure_of(ramp(2)), 2.0, 1e-6);
    EXPECT_NEAR(exposure_of(ramp(99)), 99.0, 1e-4);
    EXPECT_NEAR(exposure_of(ramp(100)), 99.0, 1e-4);
    EXPECT_NEAR(exposure_of(ramp(101)), 100.0, 1e-4);
    EXPECT_NEAR(exposure_of(ramp(200)), 198.0, 1e-4);
    EXPECT_NEAR(exposure_of(ramp(1000)), 990.0, 1e-3);
}

TEST(Exposure, IsOfLuminance) {
    const std::vector<Rgb> pixels = {Rgb(10.0f, 0.0f, 0.0f)};
    EXPECT_NEAR(exposure_of(pixels), 2.126, 1e-6);
}

TEST(Exposure, IsOneWhereThePercentileIsBlack) {
    std::vector<Rgb> pixels(100, Rgb(0.0f));
    EXPECT_EQ(exposure_of(pixels), 1.0);
    pixels[17] = Rgb(500.0f);
    EXPECT_EQ(exposure_of(pixels), 1.0);
    pixels[18] = Rgb(300.0f);
    EXPECT_NEAR(exposure_of(pixels), 300.0, 1e-3);
}

TEST(Exposure, RefusesNothingAndNaN) {
    EXPECT_THROW(exposure_of({}), std::invalid_argument);
    const std::vector<Rgb> pixels = {Rgb(1.0f), Rgb(std::numeric_limits<float>::quiet_NaN())};
    EXPECT_THROW(exposure_of(pixels), std::domain_error);
}

}  // namespace
}  // namespace probebake
