#include "bake/audit.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "bake/bake_fixture.h"
#include "bake/probe_view.h"
#include "image/exr.h"
#include "image/metrics.h"

namespace probebake {
namespace {

class AuditTest : public testing::Test {
  protected:
    static constexpr int kFace = 16;

    CubemapRender render(const RenderSettings& settings) const {
        return render_cubemap(what_, origin_, kFace, settings, cancel_);
    }
    /// Rendered with 32 × 32 leaf rays per pixel: its own mean squared error is below 2e-5.
    Cubemap truth() const {
        return render({.kind = RendererKind::kReference, .leaf_grid = 32}).color;
    }
    Audit audit(const CubemapRender& render, const Cubemap& as_written, uint64_t key,
                int pixels = 200, Weighting weighting = Weighting::kUniform) const {
        return audit_cubemap({.truth = truth_of_pixels_,
                              .as_written = as_written,
                              .aux = render.aux,
                              .exposure = 0.8,
                              .weighting = weighting,
                              .pixels = pixels,
                              .key = key},
                             cancel_);
    }

    Scene scene_ = test::small_scene();
    ProbeSpec probe_ = test::small_job(1).probes[0];
    RenderScene what_ = render_scene(scene_, probe_, LightingState::kAlbedo);
    Vec3 origin_ = scene_.to_voxels(probe_.position_m);
    TruthOf truth_of_pixels_ = voxel_truth(what_, origin_, kFace);
    CancelToken cancel_;
};

// 400 audits of one cubemap against the error measured on all its pixels: the mean must agree
// within 4 standard errors (about 5 % of the mean squared error), the 95 % intervals must cover in
// 95 % (400 runs see 90.6 %).
TEST_F(AuditTest, EstimatesTheErrorOfTheWholeCubeWithoutBias) {
    const Cubemap truth = this->truth();
    const std::pair<Weighting, RenderSettings> cases[] = {
        {Weighting::kUniform, {.kind = RendererKind::kLod}},
        {Weighting::kSolidAngle, {.threshold = 0.1}}};
    for (const auto& [weighting, settings] : cases) {
        const CubemapRender render = this->render(settings);
        const Cubemap as_written = rounded_to_file(render.color);
        const double rmse = compare_cubemaps(as_written, truth, 0.8, weighting).cube.rmse;
        const double expected = rmse * rmse;
        constexpr int kRuns = 400;
        Moments moments;
        int covered = 0;
        int covered_biased = 0;
        for (uint64_t run = 0; run < kRuns; ++run) {
            const Estimate mse =
                audit(render, as_written, random_key({run, 3}), 200, weighting).error.mse;
            moments.add(mse.value);
            const Interval interval = mse.interval(0.95);
            covered += interval.low <= expected && expected <= interval.high ? 1 : 0;
            const double biased = 1.5 * expected;
            covered_biased += interval.low <= biased && biased <= interval.high ? 1 : 0;
        }
        const double error = Estimate::of_mean(moments).standard_error();
        EXPECT_LT(error, 0.015 * expected);
        EXPECT_NEAR(moments.mean(), expected, 4.0 * error);
        EXPECT_GT(covered, 0.906 * kRuns) << covered;
        EXPECT_LT(covered_biased, 0.7 * kRuns);  // it does see an error 1.5 times as large
    }
}

// Relative errors are biased by the noise of the truth in their denominator; 300 audits of a
// cubemap see a bias of 10 %.
TEST_F(AuditTest, EstimatesTheRelativeErrorOfTheWholeCube) {
    const CubemapRender render = this->render({.kind = RendererKind::kLod});
    const Cubemap as_written = rounded_to_file(render.color);
    // Dark pixels weigh so much that the truth has to be finer than the other tests'.
    const Cubemap truth =
        this->render({.kind = RendererKind::kReference, .leaf_grid = 96, .shifted_grid = true})
            .color;
    const double expected = *compare_cubemaps(as_written, truth, 0.8).cube.rel_mse;
    Moments moments;
    for (uint64_t run = 0; run < 300; ++run) {
        const Audit audit = audit_cubemap({.truth = truth_of_pixels_,
                                           .as_written = as_written,
                                           .aux = render.aux,
                                           .exposure = 0.8,
                                           .pixels = 200,
                                           .rel_mse = true,
                                           .key = random_key({run, 8})},
                                          cancel_);
        moments.add(audit.error.rel_mse->value);
    }
    const double error = Estimate::of_mean(moments).standard_error();
    EXPECT_LT(error, 0.025 * expected);
    EXPECT_NEAR(moments.mean(), expected, 4.0 * error);
}

TEST_F(AuditTest, WindowsEstimateTheSsimOfTheWholeCube) {
    const CubemapRender render = this->render({.kind = RendererKind::kLod});
    const Cubemap as_written = rounded_to_file(render.color);
    const double expected = *compare_cubemaps(as_written, truth(), 0.8).cube.ssim;
    for (const int grid : {1, 2, 3, 4}) {
        Moments moments;
        for (uint64_t run = 0; run < 60; ++run) {
            const Audit audit = audit_cubemap({.truth = truth_of_pixels_,
                                               .as_written = as_written,
                                               .aux = render.aux,
                                               .exposure = 0.8,
                                               .pixels = 16,
                                               .windows = 24,
                                               .window_grid = grid,
                                               .key = random_key({run, 5})},
                                              cancel_);
            ASSERT_EQ(audit.windows, 24u);
            moments.add(audit.error.ssim->value);
        }
        const double error = Estimate::of_mean(moments).standard_error();
        std::printf("grid %d: %.4f, truth %.4f, standard error %.4f\n", grid, moments.mean(),
                    expected, error);
        EXPECT_LT(error, 0.02);
        EXPECT_NEAR(moments.mean(), expected, 4.0 * error + 0.01) << grid;
        EXPECT_GT(std::abs(moments.mean() - (expected - 0.12)), 4.0 * error + 0.01) << grid;
    }
}

TEST_F(AuditTest, TheSameForAnyNumberOfThreadsAndFreshForEveryKey) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    const CubemapRender render = this->render({.threshold = 0.154});
    const Cubemap as_written = rounded_to_file(render.color);
    const Audit one = audit(render, as_written, 1);
    tbb::task_arena arena(7);
    Audit seven;
    arena.execute([&] { seven = audit(render, as_written, 1); });
    EXPECT_EQ(one.error.mse.value, seven.error.mse.value);
    EXPECT_EQ(one.cost.steps, seven.cost.steps);
    EXPECT_GE(one.cost.rays, 200u * 8u);
    EXPECT_NE(one.error.mse.value, audit(render, as_written, 2).error.mse.value);
}

TEST_F(AuditTest, AnErrorInThePictureIsSeen) {
    const CubemapRender render = this->render({.kind = RendererKind::kReference});
    Cubemap spoilt = rounded_to_file(render.color);
    for (Rgb& pixel : spoilt.image().pixels()) pixel = pixel * 1.3f;
    const double clean = audit(render, rounded_to_file(render.color), 4).error.mse.value;
    EXPECT_GT(audit(render, spoilt, 4).error.mse.interval(0.95).low, 2.0 * clean);
}

}  // namespace
}  // namespace probebake
