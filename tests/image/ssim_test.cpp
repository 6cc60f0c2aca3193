#include "image/ssim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "image/cubemaps.h"
#include "math/estimate.h"
#include "math/random.h"

namespace probebake {
namespace {

LuminancePlane plane_of(const Cubemap& cubemap) {
    const size_t n = static_cast<size_t>(cubemap.face_size());
    return ssim_plane(cubemap.image().pixels().first(n * n), cubemap.face_size(), 1.0);
}

SsimWindow constant_window(double value) {
    SsimWindow window{};
    window.fill(value);
    return window;
}

TEST(Ssim, LuminanceIsDividedByTheExposureAndClipped) {
    EXPECT_NEAR(ssim_luminance(Rgb(1.0f, 0.0f, 0.0f), 1.0), 0.2126, 1e-15);
    EXPECT_NEAR(ssim_luminance(Rgb(0.0f, 2.0f, 0.0f), 4.0), 0.3576, 1e-15);
    EXPECT_NEAR(ssim_luminance(Rgb(0.0f, 0.0f, 0.5f), 1.0), 0.0361, 1e-15);
    EXPECT_EQ(ssim_luminance(Rgb(3.0f), 2.0), 1.0);
    EXPECT_TRUE(std::isnan(ssim_luminance(Rgb(std::nanf("")), 1.0)));
}

TEST(Ssim, KnownValues) {
    EXPECT_NEAR(ssim(constant_window(0.3), constant_window(0.3)), 1.0, 1e-12);
    // Two constants: only the luminance term is left, (2ab + C1) / (a² + b² + C1).
    EXPECT_NEAR(ssim(constant_window(0.2), constant_window(0.6)), 0.2401 / 0.4001, 1e-12);
    // 0.5 ± 0.1 against 0.5 ∓ 0.1 in a pattern whose weighted mean is 0.5: contrast
    // (−2·0.01 + C2) / (2·0.01 + C2) and luminance 1.
    SsimWindow pattern = constant_window(0.5);
    SsimWindow inverse = constant_window(0.5);
    for (size_t i = 0; i < pattern.size(); ++i) {
        const size_t column = i % 11;
        if (column == 5) continue;
        pattern[i] += column < 5 ? 0.1 : -0.1;
        inverse[i] -= column < 5 ? 0.1 : -0.1;
    }
    // The central column, at 0.5, has the weight g(0) of one dimension.
    double sum = 0.0;
    for (int i = -5; i <= 5; ++i) sum += std::exp(-i * i / 4.5);
    const double variance = 0.01 * (1.0 - 1.0 / sum);
    EXPECT_NEAR(ssim(pattern, inverse), (-2.0 * variance + 0.0009) / (2.0 * variance + 0.0009),
                1e-12);
}

TEST(Ssim, MapIsTheSsimOfEveryWindow) {
    const Cubemap cubemap = test::wave_cubemap(24);
    const LuminancePlane r = plane_of(cubemap);
    const LuminancePlane a = plane_of(test::with_noise(cubemap, 0.05, 4));
    const std::vector<double> map = ssim_map(a, r);
    ASSERT_EQ(map.size(), 14u * 14u);
    for (int y = 0; y < 14; ++y) {
        for (int x = 0; x < 14; ++x) {
            EXPECT_NEAR(map[static_cast<size_t>(14 * y + x)],
                        ssim(ssim_window(a, x, y), ssim_window(r, x, y)), 1e-12);
        }
    }
}

TEST(Ssim, NeedsElevenPixels) {
    const LuminancePlane ten = plane_of(test::wave_cubemap(10));
    EXPECT_TRUE(ssim_map(ten, ten).empty());
    const LuminancePlane eleven = plane_of(test::wave_cubemap(11));
    EXPECT_EQ(ssim_map(eleven, eleven).size(), 1u);
    EXPECT_THROW(ssim_map(ten, eleven), std::invalid_argument);
    EXPECT_NO_THROW(ssim_window(eleven, 0, 0));
    EXPECT_THROW(ssim_window(eleven, 1, 0), std::out_of_range);
    EXPECT_THROW(ssim_window(eleven, 0, -1), std::out_of_range);
}

TEST(Ssim, TwoReferencesWithoutNoiseAreOne) {
    const Cubemap cubemap = test::wave_cubemap(16);
    const LuminancePlane plane = plane_of(cubemap);
    const LuminancePlane noisy = plane_of(test::with_noise(cubemap, 0.1, 2));
    for (int x = 0; x < 6; ++x) {
        const SsimWindow a = ssim_window(noisy, x, 2);
        const SsimWindow r = ssim_window(plane, x, 2);
        EXPECT_NEAR(ssim(a, r, r), ssim(a, r), 1e-12);
    }
}

/// Mean over many draws of the estimate from two noisy references, of the plain formula with their
/// mean, and the standard error of the former.
struct NoiseTrial {
    double two_references = 0.0;
    double plain = 0.0;
    double standard_error = 0.0;
};
NoiseTrial run_trial(const SsimWindow& a, const SsimWindow& truth, double deviation,
                     uint64_t seed) {
    constexpr int kDraws = 4000;
    RandomStream random(seed);
    // The sum of four uniforms: near enough to normal, and a mean of jittered rays looks like it.
    const auto noisy = [&](double value) {
        double sum = -2.0;
        for (int i = 0; i < 4; ++i) sum += random.uniform();
        return value + deviation * sum * std::sqrt(3.0);
    };
    NoiseTrial trial;
    double squares = 0.0;
    for (int draw = 0; draw < kDraws; ++draw) {
        SsimWindow r1{};
        SsimWindow r2{};
        SsimWindow mean{};
        for (size_t i = 0; i < truth.size(); ++i) {
            r1[i] = noisy(truth[i]);
            r2[i] = noisy(truth[i]);
            mean[i] = (r1[i] + r2[i]) / 2.0;
        }
        const double estimate = ssim(a, r1, r2);
        trial.two_references += estimate / kDraws;
        squares += estimate * estimate / kDraws;
        trial.plain += ssim(a, mean) / kDraws;
    }
    trial.standard_error =
        std::sqrt((squares - trial.two_references * trial.two_references) / kDraws);
    return trial;
}

TEST(Ssim, TwoReferencesCancelTheNoiseThatThePlainFormulaCountsAsError) {
    struct Case {
        const char* name;
        double contrast;          // of the truth, standard deviation
        double error;             // of the image
        double noise;             // of a reference
        double allowed;           // bias of the two references, beyond 4 standard errors
        double least_plain_bias;  // by which the plain formula is too low
    };
    // Biases of 40,000 draws in an independent program: flat −0.0017 at 0.02; waves below 0.001.
    for (const Case& c : {Case{"flat, exact", 0.0, 0.0, 0.02, 0.005, 0.15},
                          Case{"flat, wrong", 0.0, 0.02, 0.02, 0.005, 0.07},
                          Case{"faint, exact", 0.02, 0.0, 0.02, 0.005, 0.08},
                          Case{"faint, wrong", 0.02, 0.02, 0.02, 0.005, 0.05},
                          Case{"waves, exact", 0.1, 0.0, 0.05, 0.002, 0.03},
                          Case{"waves, wrong", 0.1, 0.05, 0.05, 0.002, 0.02},
                          Case{"strong waves, much noise", 0.2, 0.02, 0.1, 0.004, 0.03}}) {
        SsimWindow truth{};
        SsimWindow a{};
        RandomStream random(7);
        for (size_t i = 0; i < truth.size(); ++i) {
            const double x = static_cast<double>(i % 11);
            const double y = static_cast<double>(i) / 11.0;
            truth[i] = 0.5 + c.contrast * std::sqrt(2.0) * std::sin(1.3 * x + 0.4 * y);
            a[i] = truth[i] + c.error * std::sqrt(3.0) * (2.0 * random.uniform() - 1.0);
        }
        const double exact = ssim(a, truth);
        const NoiseTrial trial = run_trial(a, truth, c.noise, 31);
        EXPECT_NEAR(trial.two_references, exact, c.allowed + 4.0 * trial.standard_error) << c.name;
        EXPECT_LT(trial.plain, exact - c.least_plain_bias) << c.name;
        RecordProperty(c.name, std::to_string(trial.two_references - exact));
        std::printf("%-26s SSIM %.4f, two references %+.4f (s.e. %.4f), plain %+.4f\n", c.name,
                    exact, trial.two_references - exact, trial.standard_error, trial.plain - exact);
    }
}

TEST(Ssim, TooMuchNoiseMakesTheEstimatePessimistic) {
    const SsimWindow flat = constant_window(0.5);
    const NoiseTrial trial = run_trial(flat, flat, 0.05, 3);
    EXPECT_LT(trial.two_references, 0.9);
    EXPECT_GT(trial.two_references, trial.plain);
}

TEST(Ssim, VariancesTellWhatNoiseTakesFromIt) {
    struct Case {
        double brightness, contrast, noise;
    };
    for (const Case& c : {Case{0.5, 0.0, 0.01}, Case{0.5, 0.0, 0.03}, Case{0.5, 0.0, 0.1},
                          Case{0.02, 0.0, 0.005}, Case{0.5, 0.05, 0.03}, Case{0.5, 0.2, 0.1}}) {
        LuminancePlane truth{24, 24, {}};
        for (int i = 0; i < 24 * 24; ++i) {
            truth.values.push_back(c.brightness + c.contrast * std::sin(1.3 * (i % 24)));
        }
        const LuminancePlane variance{24, 24,
                                      std::vector<double>(truth.values.size(), c.noise * c.noise)};
        RandomStream random(9);
        Moments found;
        Moments told;
        for (int trial = 0; trial < 200; ++trial) {
            LuminancePlane a = truth;
            for (double& value : a.values) {
                value += c.noise * std::sqrt(3.0) * (2.0 * random.uniform() - 1.0);
            }
            for (const double ssim : ssim_map(a, truth)) found.add(1.0 - ssim);
            for (const double lost : ssim_lost_to_noise(a, variance)) told.add(lost);
        }
        std::printf("brightness %.2f, contrast %.2f, noise %.3f: 1 - SSIM %.4f, told %.4f\n",
                    c.brightness, c.contrast, c.noise, found.mean(), told.mean());
        EXPECT_NEAR(told.mean() / found.mean(), 1.0, 0.12);
    }
}

TEST(Ssim, WithoutNoiseNothingIsLost) {
    const LuminancePlane image = plane_of(test::wave_cubemap(16));
    const LuminancePlane none{16, 16, std::vector<double>(256, 0.0)};
    for (const double lost : ssim_lost_to_noise(image, none)) EXPECT_EQ(lost, 0.0);
    EXPECT_TRUE(
        ssim_lost_to_noise({10, 10, std::vector<double>(100)}, {10, 10, std::vector<double>(100)})
            .empty());
    EXPECT_THROW(ssim_lost_to_noise(image, {10, 10, std::vector<double>(100)}),
                 std::invalid_argument);
}

}  // namespace
}  // namespace probebake
