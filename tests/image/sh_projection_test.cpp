#include "image/sh_projection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "image/cubemaps.h"

namespace probebake {
namespace {

// A constant 1 has L00 = √(4π) and nothing else on any grid: the cells tile the sphere, and what is
// off in the sums of Y cancels by symmetry, but for L20 and L22 on the coarsest ones.
TEST(ShProjection, AConstantHasOneCoefficient) {
    for (const int n : {1, 2, 4, 16, 64}) {
        const ShRgb sh = project_sh(
            test::make_cubemap(n, [](const CubePixel&) { return Rgb(1.0f, 2.0f, 0.0f); }));
        EXPECT_NEAR(sh[0].r, std::sqrt(4.0 * std::numbers::pi), 1e-9) << n;
        EXPECT_NEAR(sh[0].g, 2.0 * sh[0].r, 1e-9) << n;
        EXPECT_EQ(sh[0].b, 0.0);
        for (size_t i = 1; i < sh.size(); ++i) EXPECT_NEAR(sh[i].r, 0.0, 1e-12) << n << " " << i;
    }
}

// L = 0.5 + 0.5 d: L00 = √π, L1 = √(π/3) in the channel of its axis (docs/conventions.md).
TEST(ShProjection, TheDirectionCodedCubeHasTheKnownCoefficients) {
    for (const auto& [n, tolerance] : {std::pair{16, 6e-4}, std::pair{64, 4e-5}}) {
        const ShRgb sh = project_sh(test::direction_cubemap(n));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sh[0][c] / 1.7724538509, 1.0, tolerance) << n;
        const std::array<int, 3> coefficient_of_axis = {3, 1, 2};
        for (size_t i = 1; i < sh.size(); ++i) {
            for (int c = 0; c < 3; ++c) {
                const bool along =
                    static_cast<int>(i) == coefficient_of_axis[static_cast<size_t>(c)];
                EXPECT_NEAR(sh[i][c], along ? 1.0233267079 : 0.0, 1.0233 * tolerance)
                    << n << " " << i << " " << c;
            }
        }
    }
}

// Weights of texel centres, as if the grid had no shared edges, are what the clipped cells are
// there against.
TEST(ShProjection, TexelWeightsWouldBeOff) {
    const int n = 64;
    const auto radiance = [](const Vec3& d) { return 1.0 + std::pow(d.x, 4); };
    const double exact = 4.0 * std::numbers::pi * (1.0 + 1.0 / 5.0) * 0.28209479177387814;
    const Cubemap cube = test::make_cubemap(n, [&](const CubePixel& p) {
        return Rgb(static_cast<float>(radiance(test::pixel_direction(p, n))));
    });
    EXPECT_NEAR(project_sh(cube)[0].r / exact, 1.0, 1e-4);
    double sum = 0.0;
    double weights = 0.0;
    for (size_t i = 0; i < cube.image().pixels().size(); ++i) {
        const CubePixel p = pixel_at(i, n);
        const double u = (2.0 * p.x + 1.0) / n - 1.0;
        const double v = (2.0 * p.y + 1.0) / n - 1.0;
        const double weight = std::pow(1.0 + u * u + v * v, -1.5);
        sum += weight * static_cast<double>(cube.at(p).r);
        weights += weight;
    }
    const double wrong = sum / weights * 4.0 * std::numbers::pi * 0.28209479177387814;
    std::printf("off by %.1e, with texel weights %.1e\n", project_sh(cube)[0].r / exact - 1.0,
                wrong / exact - 1.0);
    EXPECT_GT(std::abs(wrong / exact - 1.0), 1e-3);
}

// |E(n) − E'(n)| ≤ 1.4415 ‖ΔL‖₂, and no smaller factor would do.
TEST(ShProjection, TheIrradianceIsOffByNoMoreThanTheBound) {
    RandomStream random(5);
    const auto symmetric = [&] { return 2.0 * random.uniform() - 1.0; };
    for (int run = 0; run < 1000; ++run) {
        const Vec3 normal = glm::normalize(Vec3(symmetric(), symmetric(), symmetric()));
        const Sh9 basis = sh_basis(normal);
        double norm2 = 0.0;
        double irradiance = 0.0;
        double worst2 = 0.0;
        for (size_t i = 0; i < basis.size(); ++i) {
            const double difference = symmetric();
            norm2 += difference * difference;
            irradiance += kShIrradiance[i] * difference * basis[i];
            worst2 += std::pow(kShIrradiance[i] * basis[i], 2);
        }
        ASSERT_LE(std::abs(irradiance), kShLargestIrradiance * std::sqrt(norm2));
        ASSERT_NEAR(std::sqrt(worst2), kShLargestIrradiance, 5e-5);  // of the worst ΔL for `normal`
    }
}

}  // namespace
}  // namespace probebake
