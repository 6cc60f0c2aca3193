#include "bake/irradiance_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bake/bake_fixture.h"
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
            probes, all, [](const CoarsePixel&, CostStats&) { return Rgb(float{kBright}); });
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

TEST(IrradianceNoise, IsUnknownWhereNothingIsSeenButNoise) {
    const IrradianceNorms black{{{0, 0.0}}, {}};
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
    ASSERT_EQ(pilot.curve.size(), 4U);
    for (const CurvePoint& point : pilot.curve) {
        ASSERT_TRUE(point.irradiance_square);
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
        const Interval interval = point.irradiance_square->interval(0.95);
        EXPECT_GT(std::sqrt(found), 0.8 * std::sqrt(std::max(0.0, interval.low)));
        EXPECT_LT(std::sqrt(found), 1.25 * std::sqrt(interval.high));
        EXPECT_LT(interval.high, 2.0 * interval.low);
        std::printf("leaf grid %d: predicted %.5f [%.5f, %.5f], found %.5f\n",
                    point.settings.leaf_grid, std::sqrt(point.irradiance_square->value),
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
