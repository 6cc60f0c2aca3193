// Bakes through media: targets, audits, forced trackers, and what is refused.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

#include "bake/media_fixture.h"
#include "bake/report.h"

namespace probebake {
namespace {

using test::cloud;
using test::day_request;
using test::haze;
using test::kFace;
using test::kTarget;
using test::MediaBake;

TEST_F(MediaBake, MeetsItsTargetAndSaysWhatItCost) {
    Json request = day_request();
    request["products"] = {"cube", "aux"};
    request["quality"]["evidence"] = {{"pixels_per_probe", 500}};
    const JobSpec job = read_job(request);
    const Plan plan = make_plan(scene_, job);
    ASSERT_TRUE(plan.media);
    EXPECT_EQ(plan.media->choice.tracker, TrackerKind::kDelta);
    EXPECT_EQ(plan.media->media.size(), 2u);

    const Pilot pilot = this->pilot(job);
    EXPECT_GE(pilot.curve.size(), 5u);
    EXPECT_LT(pilot.curve.back().error.mse.value, pilot.curve.front().error.mse.value);
    const ProbeResult result = bake_probe(scene_, job, pilot, {.probe = 1}, cancel_);
    EXPECT_LE(result.certificate.error.mse.value, kTarget * kTarget);
    EXPECT_GT(result.certificate.error.mse.value, 0.2 * kTarget * kTarget);
    const MediaCost cost = result.render_cost().media;
    EXPECT_GT(cost.lookups, cost.collisions);
    EXPECT_GT(cost.null_collisions, 0u);
    EXPECT_GT(cost.leaves, 0u);
    EXPECT_EQ(cost.faults, 0u);
    EXPECT_GE(result.render_cost().rays, 16 * owned_pixel_count(kFace));

    const CubeAux aux = decode_aux(result.files[1].bytes, "aux.exr").aux;
    uint32_t most = 0;
    uint32_t least = 1u << 30;
    double sum = 0.0;
    for (const auto& pixel : aux.pixels) {
        most = std::max(most, pixel.samples);
        least = std::min(least, pixel.samples);
        sum += double{glm::dot(pixel.standard_error, pixel.standard_error)} / 3.0;
        EXPECT_TRUE(std::isfinite(pixel.z_m));
    }
    EXPECT_GE(least, 16u);
    EXPECT_GT(most, 2 * least);  // samples go where the variance is
    const double noise = std::sqrt(sum / static_cast<double>(aux.pixels.size()));
    EXPECT_NEAR(noise, result.settings.noise, 0.2 * result.settings.noise);
}

/// The audit's estimate against the difference of two independent bakes, and a planted error.
TEST_F(MediaBake, TheAuditSeesWhatIsWrong) {
    Json request = day_request();
    request["quality"]["evidence"] = {{"pixels_per_probe", 1500}};
    request["quality"]["exposure"] = 1.0;
    const JobSpec job = read_job(request);
    request["seed"] = 8;
    const JobSpec other = read_job(request);
    const ProbeResult a = bake(job);
    const Cubemap cube_a = cube_of(a);
    const Cubemap cube_b = cube_of(bake(other));
    double sum = 0.0;
    for (size_t i = 0; i < cube_a.image().pixels().size(); ++i) {
        const Vec3 d = Vec3(cube_a.image().pixels()[i]) - Vec3(cube_b.image().pixels()[i]);
        sum += glm::dot(d, d) / 3.0;
    }
    const double halved = sum / 2.0 / static_cast<double>(cube_a.image().pixels().size());
    const Interval interval = a.certificate.error.mse.interval(0.999);
    EXPECT_LT(interval.low, 1.15 * halved);
    EXPECT_GT(interval.high, 0.85 * halved);

    // A render of a medium twice as dense as the one that it is audited against.
    const Pilot right = pilot(job);
    Scene denser = test::small_scene();
    denser.media = Media({cloud(Rgb(0.2f), Rgb(1.8f)), haze()});
    const Pilot wrong = run_pilot(denser, job, make_plan(denser, job),
                                  light_state(denser, job, 0, cancel_), cancel_);
    const VolumeView view = volume_view(scene_, job.probes[0], 99);
    const auto audited = [&](const Pilot& rendered) {
        const CubemapRender render =
            render_through_media(scene_, *rendered.media->tracer, view,
                                 {.kind = RendererKind::kPaths, .samples = 128}, {}, cancel_);
        const AuditSpec spec{.truth =
                                 [&](const CubePixel& owner, int, uint64_t key, CostStats& stats) {
                                     return path_truth(*right.media->tracer, view, owner, 64, key,
                                                       stats);
                                 },
                             .as_written = render.color,
                             .aux = render.aux,
                             .exposure = 1.0,
                             .pixels = 800,
                             .key = 5};
        return audit_cubemap(spec, cancel_).error.mse;
    };
    EXPECT_GT(audited(wrong).interval(0.99).low, audited(right).interval(0.99).high);
}

TEST_F(MediaBake, EveryTrackerGivesTheSamePicture) {
    scene_.media = Media({cloud(Rgb(0.1f, 0.2f, 0.3f), Rgb(0.5f, 0.8f, 1.2f)), haze()});
    Json request = day_request({{"rays", 64 * owned_pixel_count(kFace)}});
    request["quality"]["evidence"] = {{"audit", false}};
    std::array<Moments, 3> reference;
    for (const char* tracker : {"history_average", "weighted_decomposition", "spectral_mis"}) {
        request["quality"]["tracker"] = tracker;
        const JobSpec job = read_job(request);
        const ProbeResult result = bake(job);
        EXPECT_EQ(result.render_cost().media.faults, 0u) << tracker;
        EXPECT_LE(result.render_cost().rays, 64 * owned_pixel_count(kFace));
        EXPECT_GE(result.render_cost().rays, 62 * owned_pixel_count(kFace)) << tracker;
        const Cubemap cube = cube_of(result);  // decoding refuses what is negative or not finite
        for (int c = 0; c < 3; ++c) {
            double mean = 0.0;
            for (const Rgb& pixel : cube.image().pixels()) mean += double{pixel[c]};
            mean /= static_cast<double>(cube.image().pixels().size());
            reference[static_cast<size_t>(c)].add(mean);
            // Sees a bias of 5 % of the mean radiance.
            EXPECT_NEAR(mean, reference[static_cast<size_t>(c)].mean(), 0.05 * mean) << tracker;
        }
    }
}

TEST_F(MediaBake, AlbedoIsThatOfASceneWithoutMedia) {
    const JobSpec job = test::small_job();
    const ProbeResult through = bake(job);
    EXPECT_EQ(through.render_cost().media, MediaCost{});
    EXPECT_FALSE(make_plan(scene_, job).media);
    scene_.media = Media();
    EXPECT_EQ(through.files[0].sha256, bake(job).files[0].sha256);
}

TEST_F(MediaBake, TheSameBytesForAnyNumberOfThreads) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    Json request = day_request({{"psnr_db", 18}});
    request["products"] = {"cube", "aux", "sh"};
    const JobSpec job = read_job(request);
    const ProbeResult one = bake(job);
    for (const int threads : {1, 7}) {
        tbb::task_arena arena(threads);
        ProbeResult many;
        arena.execute([&] { many = bake(job); });
        for (size_t i = 0; i < one.files.size(); ++i) {
            EXPECT_EQ(many.files[i].sha256, one.files[i].sha256) << threads;
        }
    }
}

/// A furnace: a medium that absorbs nothing under a sky of 1 is not seen.
TEST_F(MediaBake, AWhiteFurnaceIsWhite) {
    scene_.tree = VoxelTree::build({.depth = 4});
    scene_.media = Media({cloud(Rgb(0.0f), Rgb(1.0f, 2.0f, 3.0f))});
    Json request = test::small_request(1, {{"rmse", 0.05}});
    request["lighting_states"] = Json::parse(
        R"([{"id": "furnace", "sky": {"type": "constant", "radiance_w_m2_sr": [1, 1, 1]}}])");
    request["probes"]["list"][0]["position_m"] = {0.4, 6.4, 10.4};  // within the cloud
    request["face_size_px"] = kFace;
    request["quality"]["exposure"] = 1.0;
    const ProbeResult result = bake(read_job(request));
    const Cubemap cube = cube_of(result);
    double sum = 0.0;
    for (const Rgb& pixel : cube.image().pixels()) {
        sum += double{pixel.r + pixel.g + pixel.b} / 3.0;
    }
    EXPECT_NEAR(sum / 384.0, 1.0, 0.01);
    EXPECT_GT(result.render_cost().media.collisions, 0u);
}

TEST_F(MediaBake, IrradianceAndSsimAreTargetsToo) {
    scene_.media = Media({haze()});
    for (const Json& targets : {Json{{"irradiance_rel", 0.1}}, Json{{"ssim", 0.7}}}) {
        Json request = day_request(targets);
        request["face_size_px"] = 12;
        const JobSpec job = read_job(request);
        const ProbeResult result = bake(job);
        EXPECT_TRUE(result.target_met) << targets;
    }
}

TEST_F(MediaBake, WhatNoRenderReachesIsNotPilotedEither) {
    Json request = day_request({{"psnr_db", 150}});
    request["face_size_px"] = 1;
    request["probes"]["list"].erase(1);
    const JobSpec job = read_job(request);
    const Pilot pilot = this->pilot(job);
    EXPECT_LE(pilot.curve.back().settings.samples, kMostPathsPerPixel);
    EXPECT_LE(pilot.search_cost.rays, 3 * kMostPathsPerPixel * 6);
}

TEST_F(MediaBake, PilotAndRenderEndSoonAfterACancellation) {
    Json request = day_request({{"psnr_db", 90}});
    request["face_size_px"] = 64;
    const JobSpec job = read_job(request);
    const ReadyState state = light_state(scene_, job, 0, cancel_);
    const VolumeView view = volume_view(scene_, job.probes[0], 0);
    const Pilot coarse = pilot(read_job(day_request()));
    const RenderSettings settings{.kind = RendererKind::kPaths, .samples = kMostPathsPerPixel};
    const auto seconds_after_cancellation =
        [](const std::function<void(const CancelToken&)>& work) {
            using Clock = std::chrono::steady_clock;
            CancelToken cancel;
            Clock::time_point at;
            std::jthread later([&] {
                std::this_thread::sleep_for(std::chrono::milliseconds(300));
                at = Clock::now();
                cancel.cancel();
            });
            EXPECT_THROW(work(cancel), Cancelled);
            later.join();
            return std::chrono::duration<double>(Clock::now() - at).count();
        };
    EXPECT_LT(seconds_after_cancellation([&](const CancelToken& cancel) {
                  run_pilot(scene_, job, make_plan(scene_, job), state, cancel);
              }),
              1.0);
    EXPECT_LT(seconds_after_cancellation([&](const CancelToken& cancel) {
                  render_through_media(scene_, *coarse.media->tracer, view, settings, {}, cancel);
              }),
              1.0);
}

TEST_F(MediaBake, AUnitKeepsToItsSeconds) {
    Json request = day_request({{"rmse", 0.004}});
    request["face_size_px"] = 32;
    const JobSpec job = read_job(request);
    const Pilot pilot = this->pilot(job);
    constexpr double kSeconds = 1.0;
    const ProbeResult result =
        bake_probe(scene_, job, pilot, {.probe = 1, .seconds = kSeconds}, cancel_);
    const double taken = result.render_cost().seconds + result.earlier_renders.seconds;
    EXPECT_TRUE(result.limited);
    EXPECT_FALSE(result.target_met);
    EXPECT_GT(taken, 0.3 * kSeconds);
    EXPECT_LT(taken, 1.5 * kSeconds);
    const ProbeResult once = bake_probe(scene_, job, pilot, {.probe = 1, .seconds = 0.0}, cancel_);
    EXPECT_TRUE(once.limited);
    EXPECT_LT(once.render_cost().rays, result.render_cost().rays);
}

TEST_F(MediaBake, EmissionIsSeenThroughMedia) {
    MediumSpec fire = cloud(Rgb(0.5f), Rgb(0.1f));
    fire.emission = Rgb(2.0f, 1.0f, 0.5f);
    scene_.media = Media({fire});
    Json request = test::small_request(1, {{"rmse", 0.1}});
    request["face_size_px"] = kFace;
    request["lighting_states"] = Json::array({"emission"});
    const Cubemap cube = cube_of(bake(read_job(request)));
    Vec3 sum(0.0);
    for (const Rgb& pixel : cube.image().pixels()) sum += Vec3(pixel);
    EXPECT_GT(sum.r, 0.0);
    EXPECT_NEAR(sum.g / sum.r, 0.5, 0.05);
    EXPECT_NEAR(sum.b / sum.r, 0.25, 0.05);
}

TEST_F(MediaBake, WhatCannotBeIsRefused) {
    EXPECT_EQ(refused(day_request()), "");
    const auto with = [&](const std::function<void(Json&)>& change) {
        Json request = day_request();
        change(request);
        return refused(request);
    };
    EXPECT_EQ(with([](Json& r) { r["quality"]["tracker"] = "woodcock"; }), "/quality/tracker");
    EXPECT_EQ(with([](Json& r) { r["quality"]["tracker"] = "none"; }), "/quality/tracker");
    EXPECT_EQ(with([](Json& r) { r["quality"]["tracker"] = "closed_form"; }), "/quality/tracker");
    EXPECT_EQ(with([](Json& r) { r["quality"]["tracker"] = "spectral_mis"; }), "");
    EXPECT_EQ(with([](Json& r) { r["quality"]["renderer"] = "hybrid"; }), "/quality/renderer");
    EXPECT_EQ(with([](Json& r) { r["quality"]["against"] = "reference"; }), "/quality/against");
    EXPECT_EQ(with([](Json& r) { r["lighting_states"][0]["radiance_per"] = "voxel"; }),
              "/lighting_states/0/radiance_per");
    EXPECT_EQ(with([](Json& r) {
                  r["quality"]["targets"] = {{"rays", 500}};
              }),
              "/quality/targets/rays");
    // A renderer is for the state that is not seen through media.
    EXPECT_EQ(with([](Json& r) {
                  r["lighting_states"].push_back("albedo");
                  r["quality"]["renderer"] = "hybrid";
              }),
              "");
    EXPECT_EQ(with([](Json& r) {
                  r["lighting_states"] = Json::array({"albedo"});
                  r["quality"]["tracker"] = "delta";
              }),
              "/quality/tracker");
    scene_.media = Media();
    EXPECT_EQ(with([](Json& r) { r["quality"]["tracker"] = "delta"; }), "/quality/tracker");
}

TEST_F(MediaBake, EndlessMediaAreWarnedOf) {
    const JobSpec job = read_job(day_request());
    const size_t before = make_plan(scene_, job).warnings.size();
    MediumSpec endless = haze();
    endless.shape = HomogeneousShape{};
    scene_.media = Media({endless});
    EXPECT_EQ(make_plan(scene_, job).warnings.size(), before + 1);
}

TEST_F(MediaBake, TheReportSaysWhichTrackerAndWhy) {
    Json request = day_request({{"rmse", 0.3}});
    const JobSpec job = read_job(request);
    const Plan plan = make_plan(scene_, job);
    const std::vector<Pilot> pilots{pilot(job)};
    const std::vector<ProbeResult> results{
        bake_probe(scene_, job, pilots[0], {.probe = 0}, cancel_),
        bake_probe(scene_, job, pilots[0], {.probe = 1}, cancel_)};
    const Json report = write_report(
        {.scene = scene_, .job = job, .plan = plan, .pilots = pilots, .results = results});
    EXPECT_EQ(report["plan"]["media"]["tracker"], "delta");
    EXPECT_FALSE(report["plan"]["media"]["reason"].get<std::string>().empty());
    const Json& state = report["states"][0];
    EXPECT_EQ(state["settings"]["renderer"], "paths");
    EXPECT_EQ(state["media"]["rivals"].size(), 2u);
    EXPECT_GE(state["media"]["octree_depths"].size(), 2u);
    const Json& cost = state["cost"]["render"]["media"];
    for (const char* key : {"samples", "lookups", "leaves", "collisions", "null_collisions"}) {
        EXPECT_GT(cost[key].get<uint64_t>(), 0u) << key;
    }
    EXPECT_TRUE(state["cost"]["audit"].contains("media"));
    EXPECT_FALSE(state.contains("lighting"));
    bool emission_left_out = false;
    for (const Json& left : report["plan"]["left_out"]) {
        emission_left_out = emission_left_out || left["what"] == "emission";
    }
    EXPECT_TRUE(emission_left_out);
}

}  // namespace
}  // namespace probebake
