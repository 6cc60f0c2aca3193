#include "bake/irradiance_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "bake/pilot.h"
#include "bake/report.h"
#include "bake/report_page.h"
#include "image/sh_projection.h"
#include "math/random.h"
#include "render/render.h"

namespace probebake {
namespace {

constexpr double kBright = 2.0;

/// Standard deviation of a pixel's noise: many times larger on one side than on the other.
double sigma_at(const CubePixel& owner) { return owner.face == kCubeFaces[2] ? 0.8 : 0.05; }

TEST(IrradianceNoise, IsTheErrorOfPixelsThatErrIndependently) {
    constexpr int kRuns = 400;
    for (const int n : {1, 2, 3, 16}) {
        std::vector<NoisyPixel> all;
        for (const CubeFace face : kCubeFaces) {
            for (int y = 0; y < n; ++y) {
                for (int x = 0; x < n; ++x) {
                    const double sigma = sigma_at(owner_of({face, x, y}, n));
                    all.push_back({0, {face, x, y}, n, 3.0 * sigma * sigma});
                }
            }
        }
        std::vector<ProbeSpec> probes(1);
        probes[0].face_size_px = n;
        const IrradianceNorms norms = coarse_irradiance_norms(
            probes, all,
            [](const CoarsePixel&, CostStats&) { return CoarseColor{Rgb(float{kBright})}; });
        const std::optional<Estimate> expected = expected_irradiance_square(all, norms);
        ASSERT_TRUE(expected);

        Cubemap constant(n);
        for (const NoisyPixel& at : all) constant.at(at.pixel) = Rgb(float{kBright});
        const double norm = irradiance_norm(project_sh(constant));
        EXPECT_NEAR(norms.of_probe.at(0), norm, 1e-3 * norm);
        Moments squares;
        for (uint64_t run = 0; run < kRuns; ++run) {
            RandomStream random(random_key({run, static_cast<uint64_t>(n)}));
            Cubemap noise(n);
            for (const NoisyPixel& at : all) {
                // Uniform, of the same variance.
                const double a = std::sqrt(3.0) * sigma_at(owner_of(at.pixel, n));
                for (int c = 0; c < 3; ++c) {
                    noise.at(at.pixel)[c] = static_cast<float>(a * (2.0 * random.uniform() - 1.0));
                }
            }
            noise.share_edges();
            const double error = irradiance_norm(project_sh(noise)) / norm;
            squares.add(error * error);
        }
        const Estimate found = Estimate::of_mean(squares);
        EXPECT_NEAR(expected->value, found.value, 4.0 * found.standard_error() + 0.01 * found.value)
            << n;
    }
}

/// Gray noise, as of a path that meets the sun: of all pixels, or of one alone.
void expect_noise_as_predicted(const std::function<float(const CubePixel&)>& sigma_of) {
    constexpr int kN = 8;
    constexpr int kRuns = 3000;
    Cubemap constant(kN);
    for (Rgb& pixel : constant.image().pixels()) pixel = Rgb(float{kBright});
    std::vector<PixelAux> aux(constant.image().pixels().size());
    for (size_t i = 0; i < aux.size(); ++i) {
        aux[i].standard_error = Rgb(sigma_of(owner_of(pixel_at(i, kN), kN)));
    }
    const IrradianceNoise predicted = irradiance_noise(constant, aux);
    const double norm = irradiance_norm(project_sh(constant));
    Moments squares;
    Moments of_red;
    for (uint64_t run = 0; run < kRuns; ++run) {
        RandomStream random(random_key({run, 77}));
        Cubemap noise(kN);
        for (size_t i = 0; i < aux.size(); ++i) {
            const double a = std::sqrt(3.0) * double{aux[i].standard_error.r};
            noise.at(pixel_at(i, kN)) = Rgb(static_cast<float>(a * (2.0 * random.uniform() - 1.0)));
        }
        noise.share_edges();
        const ShRgb sh = project_sh(noise);
        const double error = irradiance_norm(sh) / norm;
        squares.add(error * error);
        double red = 0.0;
        for (const Vec3& c : sh) red += c.r * c.r;
        of_red.add(red);
    }
    const double error = 4.0 / std::sqrt(double{kRuns});
    EXPECT_NEAR(squares.mean() / predicted.square, 1.0, error * predicted.spread);
    EXPECT_NEAR(of_red.mean() / predicted.channels.r, 1.0, error * std::numbers::sqrt2);
    // Uniform noise of one pixel has a square that varies less than a normal variable's.
    const double spread = std::sqrt(squares.variance()) / squares.mean();
    EXPECT_LT(spread, 1.1 * predicted.spread);
    EXPECT_GT(spread, 0.6 * predicted.spread);
}

TEST(IrradianceNoise, OfACubemapIsThatOfItsPixelsVariances) {
    expect_noise_as_predicted(
        [](const CubePixel& p) { return p.face == kCubeFaces[2] ? 0.8f : 0.05f; });
    expect_noise_as_predicted([](const CubePixel& p) {
        return p.face == kCubeFaces[1] && p.x == 3 && p.y == 5 ? 1.0f : 0.0f;
    });
    expect_noise_as_predicted([](const CubePixel&) { return 0.3f; });
    EXPECT_EQ(irradiance_noise(Cubemap(2), std::vector<PixelAux>(24)).square, 0.0);
}

TEST(IrradianceNoise, IsUnknownWhereNothingIsSeenButNoise) {
    const IrradianceNorms black{.of_probe = {{0, 0.0}}};
    EXPECT_FALSE(expected_irradiance_square({{0, {kCubeFaces[0], 1, 1}, 4, 1.0}}, black));
    const auto exact = expected_irradiance_square(
        {{0, {kCubeFaces[0], 1, 1}, 4, 0.0}, {0, {kCubeFaces[0], 1, 2}, 4, 0.0}}, black);
    ASSERT_TRUE(exact);
    EXPECT_TRUE(exact->nothing_found());
}

TEST(IrradianceNoise, CurveOfLeafRaysTellsWhatCubemapsAreWrongBy) {
    const Scene scene = test::small_scene();
    const JobSpec job = test::small_job(4, {{"irradiance_rel", 0.02}});
    const CancelToken cancel;
    const Plan plan = make_plan(scene, job);
    const Pilot pilot = run_pilot(scene, job, plan, LightingState::kAlbedo, cancel);
    ASSERT_EQ(pilot.curve.size(), 5U);
    for (const CurvePoint& point : pilot.curve) {
        ASSERT_TRUE(point.error.irradiance_square);
        double found = 0.0;
        for (const ProbeSpec& probe : job.probes) {
            const RenderScene what = render_scene(scene, probe, pilot.state);
            const auto sh = [&](const RenderSettings& settings) {
                return project_sh(render_cubemap(what, scene.to_voxels(probe.position_m),
                                                 probe.face_size_px, settings, cancel)
                                      .color);
            };
            const ShRgb truth = sh({.kind = RendererKind::kReference, .leaf_grid = 24});
            ShRgb difference = sh(point.settings);
            for (size_t i = 0; i < truth.size(); ++i) difference[i] -= truth[i];
            const double relative = irradiance_norm(difference) / irradiance_norm(truth);
            found += relative * relative / static_cast<double>(job.probes.size());
        }
        const Interval interval = point.error.irradiance_square->interval(0.95);
        EXPECT_GT(std::sqrt(found), 0.8 * std::sqrt(std::max(0.0, interval.low)));
        EXPECT_LT(std::sqrt(found), 1.25 * std::sqrt(interval.high));
        EXPECT_LT(interval.high, 2.0 * interval.low);
        std::printf("leaf grid %d: predicted %.5f [%.5f, %.5f], found %.5f\n",
                    point.settings.leaf_grid, std::sqrt(point.error.irradiance_square->value),
                    std::sqrt(std::max(0.0, interval.low)), std::sqrt(interval.high),
                    std::sqrt(found));
    }
    const std::vector<Pilot> pilots = {pilot};
    const std::vector<ProbeResult> results = {bake_probe(scene, job, pilot, {}, cancel)};
    const Json report = write_report(
        {.scene = scene, .job = job, .plan = plan, .pilots = pilots, .results = results});
    const Json& curve = report["states"][0]["curve"];
    EXPECT_TRUE(curve[0]["chosen"]);
    EXPECT_GT(curve[0]["error"]["irradiance_rel"], curve[3]["error"]["irradiance_rel"]);
    const std::string page = report_page(report);
    EXPECT_NE(page.find("target: irradiance_rel 0.02"), std::string::npos);
    EXPECT_NE(page.find("<circle"), std::string::npos);
    EXPECT_EQ(page.find("There is no curve"), std::string::npos);
}

}  // namespace
}  // namespace probebake
