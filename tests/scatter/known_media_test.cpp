// Half-infinite and plane-parallel media against published solutions.
//
// Half space, isotropic scattering, albedo ω (Chandrasekhar 1960, "Radiative Transfer", §§ 33-39):
// for a sun of irradiance F on a surface that faces it, from the cosine μ0, the radiance that comes
// back along the cosine μ is
//
//   I(μ) = ω/(4π) · F · μ0 / (μ + μ0) · H(μ) H(μ0)
//
// and under a sky of radiance 1 it is 1 − H(μ) √(1 − ω). H solves
// 1/H(μ) = √(1 − ω) + (ω/2) ∫ H(x) x / (μ + x) dx; its values are checked against Chandrasekhar's
// table XI and moments first.
#include <numbers>
#include <vector>

#include "scatter/scatter_fixture.h"
#include "volume/phase.h"

namespace probebake {
namespace {

using test::expect_mean;
using test::World;

class HFunction {
  public:
    explicit HFunction(double albedo) : albedo_(albedo), h_(kNodes, 1.0) {
        for (int round = 0; round < 500; ++round) {
            std::vector<double> next(kNodes);
            for (size_t i = 0; i < kNodes; ++i) next[i] = evaluate(node(i));
            // Averaging damps the iteration, which converges slowly for ω = 1.
            for (size_t i = 0; i < kNodes; ++i) h_[i] = 0.5 * (h_[i] + next[i]);
        }
    }
    double operator()(double mu) const { return evaluate(mu); }

  private:
    static constexpr size_t kNodes = 200;
    static double node(size_t i) { return (static_cast<double>(i) + 0.5) / kNodes; }

    double evaluate(double mu) const {
        double sum = 0.0;
        for (size_t i = 0; i < kNodes; ++i) sum += h_[i] * node(i) / (mu + node(i));
        return 1.0 / (std::sqrt(1.0 - albedo_) + 0.5 * albedo_ * sum / kNodes);
    }

    double albedo_;
    std::vector<double> h_;
};

TEST(KnownMedia, TheHFunctionIsChandrasekhars) {
    // Table XI for ω = 1, and the zeroth moment of all (§ 38).
    EXPECT_NEAR(HFunction(1.0)(1.0), 2.9078, 0.01);
    EXPECT_NEAR(HFunction(1.0)(0.5), 2.0128, 0.01);
    for (const double albedo : {0.3, 0.5, 0.8, 0.9, 0.99}) {
        const HFunction h(albedo);
        double mean = 0.0;
        for (int i = 0; i < 1000; ++i) mean += h((i + 0.5) / 1000.0) / 1000.0;
        EXPECT_NEAR(mean, 2.0 / albedo * (1.0 - std::sqrt(1.0 - albedo)), 1e-3) << albedo;
    }
}

World half_space(double albedo) {
    World world;
    const auto scatter = static_cast<float>(albedo);
    world.media = Media({{.name = "half space",
                          .absorption_per_m = Rgb(1.0f - scatter),
                          .scattering_per_m = Rgb(scatter),
                          .shape = HomogeneousShape{Box{{-1e9, -1e9, -1e9}, {1e9, 0, 1e9}}}}});
    return world;
}

Vec3 down(double mu) { return {std::sqrt(1.0 - mu * mu), -mu, 0.0}; }

TEST(KnownMedia, AHalfSpaceInTheSunShowsChandrasekharsRadiance) {
    for (const double albedo : {0.5, 0.9}) {
        const HFunction h(albedo);
        for (const double mu0 : {1.0, 0.3}) {
            for (const double mu : {0.9, 0.2}) {
                World world = half_space(albedo);
                // The sun at another azimuth than the eye: isotropic scattering does not mind.
                world.lighting.sun = Sun{.direction = {0.0, mu0, std::sqrt(1.0 - mu0 * mu0)},
                                         .irradiance = Rgb(1.0f)};
                const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
                const auto got = test::mean_radiance(tracer, 40000, 8, [&](RandomStream&) {
                    return Ray{Vec3(0, 1, 0), down(mu)};
                });
                const double exact =
                    albedo / (4.0 * std::numbers::pi) * mu0 / (mu + mu0) * h(mu) * h(mu0);
                SCOPED_TRACE(testing::Message()
                             << "albedo " << albedo << ", " << mu0 << " to " << mu);
                expect_mean(got, 1, exact);
                EXPECT_LT(got.sigma(1), 0.02 * exact);  // so that 8 % would be seen
            }
        }
    }
}

TEST(KnownMedia, AHalfSpaceUnderAWhiteSkyShowsTheLawOfDiffuseReflection) {
    for (const double albedo : {0.3, 0.8, 0.99}) {
        const HFunction h(albedo);
        World world = half_space(albedo);
        world.lighting.sky = Sky(SkyGradient{Rgb(1.0f), Rgb(1.0f), Rgb(0.0f)});
        for (const TrackerKind kind :
             {TrackerKind::kClosedForm, TrackerKind::kDelta, TrackerKind::kHistoryAverage}) {
            const PathTracer tracer(world.scene(), test::forced(world.media, kind));
            for (const double mu : {1.0, 0.4}) {
                const auto got = test::mean_radiance(tracer, 20000, 9, [&](RandomStream&) {
                    return Ray{Vec3(0, 1, 0), down(mu)};
                });
                SCOPED_TRACE(testing::Message() << name_of(kind) << ", albedo " << albedo);
                const double exact =
                    1.0 - h(mu) * std::sqrt(1.0 - double{static_cast<float>(albedo)});
                expect_mean(got, 0, exact);
                EXPECT_LT(got.sigma(0), 0.02 * exact);
            }
        }
    }
}

// Conservative isotropic slabs under a white sky from above: the plane albedo is 1 − T, with the
// diffuse transmission of diffuse light for τ = 1: 0.5534 (Heaslet and Warming 1965; the view
// factor of a gray slab in radiative equilibrium, e.g. Modest, "Radiative Heat Transfer", table
// 14.1, which lists 0.5532 for τ = 1, 0.3900 for τ = 2, 0.2077 for τ = 5).
TEST(KnownMedia, SlabsTransmitWhatTheTablesSay) {
    const std::vector<std::pair<double, double>> table = {
        {1.0, 0.5532}, {2.0, 0.3900}, {5.0, 0.2077}};
    for (const auto& [tau, transmitted] : table) {
        World world;
        world.media = Media({{.name = "slab",
                              .scattering_per_m = Rgb(static_cast<float>(tau)),
                              .shape = HomogeneousShape{Box{{-1e6, 0, -1e6}, {1e6, 1, 1e6}}}}});
        world.lighting.sky = Sky(SkyGradient{Rgb(1.0f), Rgb(1.0f), Rgb(0.0f)});
        const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
        // Flux below the slab: cosine-weighted directions of view.
        const auto got = test::mean_radiance(tracer, 100000, 10, [](RandomStream& random) {
            const double cosine = std::sqrt(1.0 - random.uniform());
            return Ray{Vec3(0, -1, 0), around(Vec3(0, 1, 0), cosine, random.uniform())};
        });
        SCOPED_TRACE(testing::Message() << "tau " << tau);
        EXPECT_NEAR(got.mean(2), transmitted, 4.0 * got.sigma(2) + 2e-4);
        EXPECT_LT(got.sigma(2), 0.01 * transmitted + 0.001);
    }
}

}  // namespace
}  // namespace probebake
