#include "bake/quality.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bake/bake_fixture.h"
#include "bake/probe_view.h"

namespace probebake {
namespace {

// The estimate of a squared error must not hang on the noise of the truth: it is the product of two
// independent differences. 12,000 runs see a bias of 4 standard errors, about 8 % of the error; the
// square of one difference has a bias of the truth's variance, which is much more.
TEST(Quality, TheSquaredErrorIsUnbiasedUnderNoise) {
    const Scene scene = test::small_scene();
    const ProbeSpec probe = test::small_job(1).probes[0];
    const RenderScene what = render_scene(scene, probe, LightingState::kAlbedo);
    const View view = face_view(scene, probe, CubeFace::kNegY);
    CostStats stats;
    for (const auto& [x, y] : {std::pair{4, 5}, std::pair{9, 3}}) {
        const Vec3 truth = uniform_pixel(what, view, x, y, 256, stats).color;
        const Rgb value(truth + Vec3(0.03, -0.02, 0.05));
        const double exposure = 0.7;
        const double expected = (0.03 * 0.03 + 0.02 * 0.02 + 0.05 * 0.05) / 3 / exposure / exposure;
        Moments product;
        Moments square;
        for (uint64_t run = 0; run < 12000; ++run) {
            const TruthPair pair =
                truth_pair(what, view, x, y, {.key = random_key({run, 11})}, stats);
            product.add(squared_error(value, pair, exposure));
            square.add(squared_error(value, {pair.r1, pair.r1}, exposure));
        }
        const double error = Estimate::of_mean(product).standard_error();
        EXPECT_LT(error, 0.02 * expected);
        EXPECT_NEAR(product.mean(), expected, 4.0 * error + 1e-6);
        EXPECT_GT(square.mean(), expected + 4.0 * error);  // the bias it must see
    }
}

TEST(Quality, TheReferenceIsExact) {
    const Scene scene = test::small_scene();
    const ProbeSpec probe = test::small_job(1).probes[0];
    const RenderScene what = render_scene(scene, probe, LightingState::kAlbedo);
    const View view = face_view(scene, probe, CubeFace::kPosX);
    CostStats stats;
    const TruthPair pair = truth_pair(what, view, 3, 3, {.against = Against::kReference}, stats);
    EXPECT_EQ(pair.r1, pair.r2);
    EXPECT_EQ(pair.r1, uniform_pixel(what, view, 3, 3, 4, stats).mean());
}

Estimate estimate(double value, double standard_error) {
    return {.value = value,
            .variance = standard_error * standard_error,
            .third_moment = 0.0,
            .samples = 1000,
            .degrees_of_freedom = 999};
}

TEST(Quality, TargetsAreJudgedByTheFarEndOfTheInterval) {
    const QualityTarget psnr{QualityTarget::Metric::kPsnrDb, 40.0};  // mean squared error 1e-4
    const MeasuredError clear{estimate(0.5e-4, 0.1e-4), {}};
    const MeasuredError close{estimate(0.9e-4, 0.1e-4), {}};
    const MeasuredError over{estimate(1.1e-4, 0.1e-4), {}};
    EXPECT_TRUE(bound_meets(psnr, clear, 0.95));
    EXPECT_FALSE(bound_meets(psnr, close, 0.95));
    EXPECT_TRUE(estimate_meets(psnr, close));
    EXPECT_FALSE(estimate_meets(psnr, over));
    const QualityTarget rmse{QualityTarget::Metric::kRmse, 0.01};
    EXPECT_TRUE(bound_meets(rmse, clear, 0.95));
    EXPECT_FALSE(estimate_meets(rmse, over));
    const QualityTarget ssim{QualityTarget::Metric::kSsim, 0.95};
    EXPECT_FALSE(estimate_meets(ssim, clear));  // not measured
    EXPECT_TRUE(bound_meets(ssim, {estimate(1, 0), estimate(0.98, 0.01)}, 0.95));
    EXPECT_FALSE(bound_meets(ssim, {estimate(1, 0), estimate(0.96, 0.01)}, 0.95));
}

TEST(Quality, AllTargetsOrAny) {
    QualitySpec quality{.targets = {{QualityTarget::Metric::kPsnrDb, 40.0},
                                    {QualityTarget::Metric::kRelMse, 0.02}}};
    MeasuredError error{estimate(0.5e-4, 0.1e-4)};
    error.rel_mse = estimate(0.03, 0.001);
    EXPECT_FALSE(bound_meets(quality, error, 0.95));
    quality.require = Require::kAny;
    EXPECT_TRUE(bound_meets(quality, error, 0.95));
    error.rel_mse = estimate(0.015, 0.001);
    quality.require = Require::kAll;
    EXPECT_TRUE(bound_meets(quality, error, 0.95));
    error.rel_mse.reset();
    EXPECT_FALSE(bound_meets(quality, error, 0.95)) << "not measured";
}

TEST(Quality, FiguresOfAnEstimate) {
    const ErrorFigures figures = figures_of(estimate(1e-4, 1e-5), 0.95);
    EXPECT_NEAR(figures.rmse, 0.01, 1e-12);
    EXPECT_NEAR(*figures.psnr_db, 40.0, 1e-9);
    EXPECT_NEAR(figures.rmse_interval.high, std::sqrt(1.196e-4), 1e-5);
    EXPECT_LT(*figures.psnr_low_db, 40.0);
    EXPECT_GT(*figures.psnr_high_db, 40.0);
    const ErrorFigures none = figures_of(estimate(0.0, 0.0), 0.95);
    EXPECT_EQ(none.rmse, 0.0);
    EXPECT_FALSE(none.psnr_db);
}

}  // namespace
}  // namespace probebake
