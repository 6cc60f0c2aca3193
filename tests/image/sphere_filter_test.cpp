// Means over the sphere: constants, linear radiance, and sums over every single pixel.
#include "image/sphere_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "image/cubemaps.h"
#include "math/sampling.h"

namespace probebake {
namespace {

/// The weights again, in double and as the papers write them: of the cosine of the angle.
double ggx_weight(double cosine, double alpha) {
    const double half_cosine2 = (1.0 + cosine) / 2.0;
    const double d = (alpha * alpha - 1.0) * half_cosine2 + 1.0;
    return cosine > 0.0 ? cosine / (d * d) : 0.0;  // D(h) / 4 · n·l, without its constants
}
double cosine_weight(double cosine, double exponent) {
    return cosine > 0.0 ? std::pow(cosine, exponent) : 0.0;
}

/// Where the pixels of a cubemap lie and what they stand for.
struct Cells {
    explicit Cells(int n) {
        for (size_t i = 0; i < 6 * static_cast<size_t>(n * n); ++i) {
            const CubePixel p = pixel_at(i, n);
            directions.push_back(test::pixel_direction(p, n));
            solid_angles.push_back(pixel_solid_angle(p.x, p.y, n));
        }
    }
    std::vector<Vec3> directions;
    std::vector<double> solid_angles;
};

/// Σ over all pixels, nothing taken together.
template <class Weight>
Vec3 mean_of_pixels(const Cubemap& cube, const Cells& cells, const Vec3& normal,
                    const Weight& weight) {
    Vec3 sum(0.0);
    double weights = 0.0;
    for (size_t i = 0; i < cells.directions.size(); ++i) {
        const double cosine = glm::dot(normal, cells.directions[i]);
        if (cosine <= 0.0) continue;
        const double w = weight(cosine) * cells.solid_angles[i];
        sum += Vec3(cube.image().pixels()[i]) * w;
        weights += w;
    }
    return sum / weights;
}

/// ∫ c w(c) dc / ∫ w(c) dc over the hemisphere: how much of a linear radiance is left.
template <class Weight>
double linear_gain(const Weight& weight) {
    constexpr int kSteps = 200'000;
    double sum = 0.0;
    double weights = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        // Finer towards c = 1, where a sharp lobe has its weight.
        const double s = (i + 0.5) / kSteps;
        const double c = 1.0 - s * s;
        sum += c * weight(c) * s;
        weights += weight(c) * s;
    }
    return sum / weights;
}

std::vector<Vec3> some_directions(int count, uint64_t seed) {
    RandomStream random(seed);
    std::vector<Vec3> directions = {{1, 0, 0},  {0, -1, 0}, {0, 0, 1},  {1, 1, 0},
                                    {-1, 0, 1}, {1, 1, 1},  {-1, -1, 1}};
    while (static_cast<int>(directions.size()) < count) {
        const Vec3 d(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
        if (glm::length(d) > 0.05 && glm::length(d) < 0.5) directions.push_back(d);
    }
    for (Vec3& d : directions) d = glm::normalize(d);
    return directions;
}

TEST(SphereFilter, AConstantStaysThatConstant) {
    for (const int n : {1, 2, 3, 4, 5, 16, 31, 64}) {
        const Cubemap cube =
            test::make_cubemap(n, [](const CubePixel&) { return Rgb(1.0f, 0.3f, 0.0f); });
        const SphereFilter filter(cube);
        for (const Vec3& normal : some_directions(40, 1)) {
            for (const Vec3& mean :
                 {filter.mean(GgxKernel{1.0f}, normal), filter.mean(GgxKernel{0.0625f}, normal),
                  filter.mean(GgxKernel{1e-6f}, normal), filter.mean(CosineKernel{}, normal),
                  filter.mean(CosineKernel{50}, normal)}) {
                // A lobe of α = 0.001 may meet no pixel of the coarsest grids with weight.
                EXPECT_NEAR(mean.r, 1.0, 1e-6) << n;
                EXPECT_NEAR(mean.g, 0.3, 1e-6) << n;
                EXPECT_EQ(mean.b, 0.0) << n;
            }
        }
    }
}

// Radiance a + b d becomes a + λ b n, whatever the kernel; λ from the kernel's own integral. The
// grid's cells stand for their centres: that, and what is taken together, is the rest.
TEST(SphereFilter, LinearRadianceKeepsItsDirectionAndLosesTheRightShare) {
    for (const auto& [n, tolerance] :
         {std::pair{16, 6e-3}, std::pair{64, 2e-3}, std::pair{128, 2e-3}}) {
        const Cubemap cube = test::direction_cubemap(n);
        const SphereFilter filter(cube);
        const auto check = [&, face_px = n, bound = tolerance](
                               const auto& kernel, const auto& weight, const char* name) {
            const double gain = linear_gain(weight);
            double largest = 0.0;
            for (const Vec3& normal : some_directions(60, 2)) {
                const Vec3 expected = 0.5 + 0.5 * gain * normal;
                largest = std::max(largest, glm::length(filter.mean(kernel, normal) - expected));
            }
            std::printf("N = %d, %s: gain %.4f, off by %.1e at most\n", face_px, name, gain,
                        largest);
            EXPECT_LT(largest, bound) << name;
        };
        check(
            GgxKernel{1.0f}, [](double c) { return ggx_weight(c, 1.0); }, "alpha 1");
        check(
            GgxKernel{0.0625f}, [](double c) { return ggx_weight(c, 0.25); }, "alpha 1/4");
        check(
            GgxKernel{1.0f / 81.0f}, [](double c) { return ggx_weight(c, 1.0 / 9.0); },
            "alpha 1/9");
        check(
            CosineKernel{}, [](double c) { return cosine_weight(c, 1.0); }, "cosine");
        check(
            CosineKernel{50}, [](double c) { return cosine_weight(c, 50.0); }, "cosine^50");
    }
    EXPECT_NEAR(linear_gain([](double c) { return ggx_weight(c, 1.0); }), 2.0 / 3.0, 1e-8);
    EXPECT_NEAR(linear_gain([](double c) { return cosine_weight(c, 50.0); }), 51.0 / 52.0, 1e-8);
}

// The figures that docs/conventions.md promises, for pictures, for noise, and for lamps of 10⁶ in
// single pixels, two of them of different colours side by side. Relative to every value.
TEST(SphereFilter, IsWithinItsErrorOfTheSumOverAllPixels) {
    for (const int n : {64, 128}) {
        const Cells cells(n);
        Cubemap lamps = test::wave_cubemap(n);
        lamps.at({CubeFace::kPosX, n / 3, n / 5}) = Rgb(1e6f, 1e5f, 1e4f);
        lamps.at({CubeFace::kPosX, n / 3 + 2, n / 5 + 1}) = Rgb(0.0f, 1e4f, 1e6f);
        lamps.at({CubeFace::kPosY, n / 2, n / 2 + 3}) = Rgb(1e6f);
        for (const auto& [name, cube] :
             {std::pair{"waves", test::wave_cubemap(n)},
              std::pair{"noise", test::random_cubemap(n, 3)}, std::pair{"lamps", lamps}}) {
            const SphereFilter filter(cube);
            std::vector<Vec3> directions = some_directions(30, 4);
            for (int i = 0; i < 32; ++i) {  // around the lamps
                directions.push_back(test::pixel_direction(
                    {CubeFace::kPosX, n / 3 - 5 + i % 8, n / 5 - 4 + i / 4}, n));
            }
            const auto check = [&, &picture = cube, title = name](
                                   const auto& kernel, const auto& weight, const char* what) {
                double largest = 0.0;
                double square = 0.0;
                for (const Vec3& normal : directions) {
                    const Vec3 exact = mean_of_pixels(picture, cells, normal, weight);
                    const Vec3 error = glm::abs(filter.mean(kernel, normal) / exact - 1.0);
                    largest = std::max({largest, error.r, error.g, error.b});
                    square += glm::dot(error, error) / 3.0;
                }
                const double rms = std::sqrt(square / static_cast<double>(directions.size()));
                std::printf("N = %d, %s, %s: rms %.1e, largest %.1e\n", n, title, what, rms,
                            largest);
                EXPECT_LT(rms, 0.005) << title << " " << what;
                EXPECT_LT(largest, 0.02) << title << " " << what;
            };
            for (const double alpha : {1.0 / 9.0, 0.25, 4.0 / 9.0, 1.0}) {
                check(
                    GgxKernel{static_cast<float>(alpha * alpha)},
                    [&](double c) { return ggx_weight(c, alpha); }, "ggx");
            }
            check(
                CosineKernel{}, [](double c) { return cosine_weight(c, 1.0); }, "cosine");
            if (cube == lamps) continue;  // cos^50 is for distances, which have none
            check(
                CosineKernel{50}, [](double c) { return cosine_weight(c, 50.0); }, "cosine^50");
        }
    }
}

// Half vectors drawn as the microfacets lie, view along the normal, each reflection weighed by n·l:
// the way engines do it, on interpolated pixels. It knows nothing of the weights above.
TEST(SphereFilter, ImportanceSamplingFindsTheSame) {
    const Cubemap cube = test::wave_cubemap(64);
    const SphereFilter filter(cube);
    constexpr uint32_t kPoints = 1u << 16;
    for (const double alpha : {0.25, 0.5, 1.0}) {
        double largest = 0.0;
        for (const Vec3& n : some_directions(12, 9)) {
            const Vec3 side = std::abs(n.z) < 0.9 ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
            const Vec3 x = glm::normalize(glm::cross(side, n));
            const Vec3 y = glm::cross(n, x);
            Vec3 sum(0.0);
            double weights = 0.0;
            for (uint32_t i = 0; i < kPoints; ++i) {
                const Vec2 u = owen_sobol(i, 0x5EED0123456789ABu);
                const double cosine2 = (1.0 - u.x) / (1.0 + (alpha * alpha - 1.0) * u.x);
                const double cosine = std::sqrt(cosine2);
                const double sine = std::sqrt(1.0 - cosine2);
                const double phi = 2.0 * std::numbers::pi * u.y;
                const Vec3 h = sine * (std::cos(phi) * x + std::sin(phi) * y) + cosine * n;
                const Vec3 l = 2.0 * cosine * h - n;
                const double weight = glm::dot(n, l);
                if (weight <= 0.0) continue;
                sum += weight * Vec3(sample_bilinear(cube, l));
                weights += weight;
            }
            const Vec3 ours = filter.mean(GgxKernel{static_cast<float>(alpha * alpha)}, n);
            const Vec3 error = glm::abs(ours - sum / weights);
            largest = std::max({largest, error.r, error.g, error.b});
        }
        std::printf("alpha %.2f: off by %.1e at most\n", alpha, largest);
        EXPECT_LT(largest, 0.006) << alpha;
    }
}

}  // namespace
}  // namespace probebake
