#include "bake/pilot.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "bake/bake_fixture.h"
#include "image/metrics.h"
#include "render/render.h"

namespace probebake {
namespace {

class PilotTest : public testing::Test {
  protected:
    Pilot pilot(const JobSpec& job) const {
        return run_pilot(scene_, job, make_plan(scene_, job), LightingState::kAlbedo, cancel_);
    }
    /// PSNR of the job's probes rendered with these settings, against 32 × 32 leaf rays.
    double true_psnr_db(const JobSpec& job, const Pilot& pilot) const {
        double mse = 0.0;
        for (const ProbeSpec& probe : job.probes) {
            const RenderScene what = render_scene(scene_, probe, LightingState::kAlbedo);
            const Vec3 origin = scene_.to_voxels(probe.position_m);
            const auto cube = [&](const RenderSettings& settings) {
                return render_cubemap(what, origin, probe.face_size_px, settings, cancel_).color;
            };
            const Cubemap truth = cube({.kind = RendererKind::kReference, .leaf_grid = 32});
            const double rmse =
                compare_cubemaps(cube(pilot.settings), truth, pilot.exposure).cube.rmse;
            mse += rmse * rmse / static_cast<double>(job.probes.size());
        }
        return -10.0 * std::log10(mse);
    }

    Scene scene_ = test::small_scene();
    CancelToken cancel_;
};

TEST_F(PilotTest, ChoosesSettingsThatMeetTheTargetWithoutOverdoingIt) {
    for (const double target_db : {18.0, 31.0}) {
        const JobSpec job = test::small_job(3, {{"psnr_db", target_db}});
        const Pilot pilot = this->pilot(job);
        EXPECT_EQ(pilot.expectation, Expectation::kTargetMet) << target_db;
        const double reached_db = true_psnr_db(job, pilot);
        EXPECT_GT(reached_db, target_db - 0.5);  // the audits promise, not the pilot
        EXPECT_LT(reached_db, target_db + 5.0);  // the pilot's own uncertainty costs some
    }
}

TEST_F(PilotTest, AHigherTargetCostsMore) {
    double before = 0.0;
    for (const double target_db : {15.0, 25.0, 34.0}) {
        const Pilot pilot = this->pilot(test::small_job(3, {{"psnr_db", target_db}}));
        for (const CurvePoint& point : pilot.curve) {
            if (!(point.settings == pilot.settings)) continue;
            EXPECT_GT(static_cast<double>(point.steps), before);
            before = static_cast<double>(point.steps);
        }
    }
    EXPECT_GT(before, 0.0);
}

TEST_F(PilotTest, TheCurveRunsFromLodOnlyToBeyondTheTarget) {
    const Pilot pilot = this->pilot(test::small_job(4, {{"psnr_db", 28.0}}));
    ASSERT_GE(pilot.curve.size(), 5u);
    EXPECT_EQ(pilot.curve.front().settings.kind, RendererKind::kLod);
    bool chosen = false;
    for (size_t i = 1; i < pilot.curve.size(); ++i) {
        EXPECT_GE(pilot.curve[i].steps, pilot.curve[i - 1].steps);
        chosen = chosen || pilot.curve[i].settings == pilot.settings;
    }
    EXPECT_TRUE(chosen);
    EXPECT_FALSE(pilot.curve.back().settings == pilot.settings);
    EXPECT_LT(pilot.curve.back().error.mse.value, 0.2 * pilot.curve.front().error.mse.value);
    EXPECT_GT(pilot.curve.back().seconds, 0.0);
}

TEST_F(PilotTest, TheReplayedSearchIsWhatTheRendererDoes) {
    const JobSpec job = test::small_job(2, {{"psnr_db", 34.0}});
    PilotSample pixels(scene_, job, LightingState::kAlbedo, cancel_);
    const std::vector<RendererKind> kinds = {RendererKind::kErrorAware, RendererKind::kReference};
    for (const int grid : kLeafGrids) pixels.extend(kinds, grid);
    const auto settings = candidate_settings(pixels.sample(), kinds, 16);
    ASSERT_GT(settings.size(), 100u);
    for (size_t i = 0; i < settings.size(); i += 41) {
        const Candidate replayed = evaluate(pixels.sample(), settings[i]);
        const CurvePoint rendered = pixels.render(settings[i]);
        const auto n = static_cast<double>(pixels.sample().pixels.size());
        EXPECT_DOUBLE_EQ(replayed.rays_per_pixel * n, static_cast<double>(rendered.rays));
        EXPECT_DOUBLE_EQ(replayed.steps_per_pixel * n, static_cast<double>(rendered.steps));
        EXPECT_NEAR(replayed.error.mse.value, rendered.error.mse.value, 1e-9);
    }
}

TEST_F(PilotTest, ReplayedPricesAreWhatTheHybridRendererDoes) {
    const JobSpec job = test::small_job(2, {{"psnr_db", 34.0}});
    PilotSample pixels(scene_, job, LightingState::kAlbedo, cancel_);
    uint64_t rays = 0;
    for (const double lowest : {1e-3, 1e-5, -1.0}) {
        pixels.extend_hybrid(lowest);
        EXPECT_GT(pixels.search_cost().rays, rays);
        rays = pixels.search_cost().rays;
        for (const RenderSettings& settings : hybrid_settings(pixels.sample(), lowest)) {
            const Candidate replayed = evaluate(pixels.sample(), settings);
            const CurvePoint rendered = pixels.render(settings);
            const auto n = static_cast<double>(pixels.sample().pixels.size());
            ASSERT_DOUBLE_EQ(replayed.rays_per_pixel * n, static_cast<double>(rendered.rays));
            ASSERT_DOUBLE_EQ(replayed.steps_per_pixel * n, static_cast<double>(rendered.steps));
            ASSERT_NEAR(replayed.error.mse.value, rendered.error.mse.value, 1e-9);
        }
    }
}

TEST_F(PilotTest, AdaptiveIsSearchedByItsNormaliser) {
    Json request = test::small_request(3, {{"psnr_db", 22.0}});
    request["quality"]["renderer"] = "adaptive";
    const JobSpec job = read_job(request);
    const Pilot pilot = this->pilot(job);
    EXPECT_EQ(pilot.settings.kind, RendererKind::kAdaptive);
    EXPECT_EQ(pilot.expectation, Expectation::kTargetMet);
    EXPECT_GT(true_psnr_db(job, pilot), 21.0);
}

TEST_F(PilotTest, SaysWhatCannotBeReached) {
    Json request = test::small_request(2, {{"psnr_db", 45.0}});
    request["quality"]["renderer"] = "lod";
    EXPECT_EQ(pilot(read_job(request)).expectation, Expectation::kUnreachable);
    Json poor = test::small_request(2, {{"psnr_db", 34.0}});
    poor["budget"]["rays"] = 6 * 16 * 16 * 2 * 3;
    const Pilot limited = pilot(read_job(poor));
    EXPECT_EQ(limited.expectation, Expectation::kBudgetExhausted);
}

TEST(TimeBudget, StatesShareTheTimeEqually) {
    constexpr double kPilotSeconds = 2.0;
    const TimeBudget budget{.threads = 3, .seconds = 40.0};
    for (const int states : {1, 4}) {
        Json request = test::small_request(5);
        request["lighting_states"] = Json::array();
        for (int s = 0; s < states; ++s) {
            request["lighting_states"].push_back(
                {{"id", "state-" + std::to_string(s)},
                 {"sun", {{"direction", {1, 3, 2}}, {"irradiance_w_m2", {9, 8, 7}}}}});
        }
        const JobSpec job = read_job(request);
        const double renders = budget.per_pixel(job, kPilotSeconds) *
                               static_cast<double>(pixel_count(job)) / budget.threads;
        const double rest = budget.seconds - states * kPilotSeconds;
        EXPECT_GT(renders, 0.7 * rest) << states;
        EXPECT_LT(renders, 0.9 * rest) << states;
        EXPECT_EQ(budget.per_pixel(job, 40.0), 0.0);  // nothing is left
    }
}

TEST_F(PilotTest, APilotThatRunsOutOfTimeBlamesTheBudget) {
    Json request = test::small_request(2, {{"psnr_db", 60.0}});
    request["quality"]["renderer"] = "reference";  // looks at one candidate, then at the clock
    const JobSpec job = read_job(request);
    const Pilot pilot = run_pilot(scene_, job, make_plan(scene_, job), LightingState::kAlbedo,
                                  cancel_, TimeBudget{.threads = 1, .seconds = 1e-6});
    EXPECT_EQ(pilot.expectation, Expectation::kBudgetExhausted);
}

TEST_F(PilotTest, ATargetOfRaysTakesTheBestThatFits) {
    const JobSpec job = test::small_job(2, {{"rays", 6 * 16 * 16 * 8}});
    const Pilot pilot = this->pilot(job);
    EXPECT_EQ(pilot.expectation, Expectation::kTargetMet);
    const Pilot poorer = this->pilot(test::small_job(2, {{"rays", 6 * 16 * 16 * 2}}));
    EXPECT_GT(true_psnr_db(job, pilot), true_psnr_db(job, poorer));
}

TEST_F(PilotTest, NoiseOfTheTruthStaysBelowTheTarget) {
    EXPECT_EQ(pilot(test::small_job(2, {{"psnr_db", 20.0}})).truth_grid, 4);
    EXPECT_GT(pilot(test::small_job(2, {{"psnr_db", 45.0}})).truth_grid, 4);
}

TEST_F(PilotTest, TheSameForAnyNumberOfThreads) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    for (const Json& targets : {Json{{"psnr_db", 30.0}}, Json{{"ssim", 0.9}}}) {
        const JobSpec job = test::small_job(3, targets);
        const Pilot one = pilot(job);
        for (const int threads : {2, 7}) {
            tbb::task_arena arena(threads);
            Pilot many;
            arena.execute([&] { many = pilot(job); });
            EXPECT_TRUE(many.settings == one.settings);
            EXPECT_EQ(many.exposure, one.exposure);
            EXPECT_EQ(many.settings_mse, one.settings_mse);
            EXPECT_EQ(many.search_cost.steps, one.search_cost.steps);
            EXPECT_EQ(many.finer.size(), one.finer.size());
        }
    }
}

TEST_F(PilotTest, ACancelledPilotThrows) {
    cancel_.cancel();
    EXPECT_THROW(pilot(test::small_job()), Cancelled);
}

}  // namespace
}  // namespace probebake
