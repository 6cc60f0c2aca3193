// Bakes through media: targets, audits, forced trackers, and what is refused.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <functional>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "bake/forecast.h"
#include "bake/learn.h"
#include "bake/report.h"
#include "image/exr.h"
#include "image/sh_projection.h"
#include "image/ssim.h"
#include "scene/generators/cumulus.h"

namespace probebake {
namespace {

MediumSpec cloud(const Rgb& absorption, const Rgb& scattering) {
    MediumSpec spec{
        .name = "cloud", .absorption_per_m = absorption, .scattering_per_m = scattering, .g = 0.6};
    GridShape shape{.density = std::make_shared<DensityGrid>(make_cumulus({.size = 32}))};
    shape.index_to_world.linear = glm::dmat3(0.4);
    shape.index_to_world.offset = Vec3(-6.0, 0.0, 4.0);
    spec.shape = std::move(shape);
    return spec;
}

MediumSpec haze() {
    return {.name = "haze",
            .absorption_per_m = Rgb(0.01f),
            .scattering_per_m = Rgb(0.02f),
            .g = 0.3,
            .shape = HomogeneousShape{Box{{-20, -5, -10}, {20, 30, 35}}}};
}

constexpr int kFace = 8;
constexpr double kTarget = 0.12;

const Json kDay = Json::parse(R"({"id": "day",
    "sun": {"direction": [1, 2, 0.5], "irradiance_w_m2": [3, 2, 1]},
    "sky": {"type": "constant", "radiance_w_m2_sr": [0.2, 0.3, 0.5]}})");

Json day_request(const Json& targets = {{"rmse", kTarget}}) {
    Json request = test::small_request(2, targets);
    request["face_size_px"] = kFace;
    request["lighting_states"] = Json::array({kDay});
    return request;
}

/// Of all windows of all faces, against two independent references.
double mean_ssim(const Cubemap& cube, const Cubemap& r1, const Cubemap& r2, double exposure) {
    const int n = cube.face_size();
    const auto planes = [&](const Cubemap& of) {
        const auto pixels = static_cast<size_t>(n) * static_cast<size_t>(n);
        std::vector<LuminancePlane> faces(kFaceCount, LuminancePlane{n, n, {}});
        for (size_t i = 0; i < kFaceCount * pixels; ++i) {
            faces[i / pixels].values.push_back(ssim_luminance(of.at(pixel_at(i, n)), exposure));
        }
        return faces;
    };
    const auto a = planes(cube);
    const auto b = planes(r1);
    const auto c = planes(r2);
    Moments windows;
    for (size_t face = 0; face < kFaceCount; ++face) {
        for (int y = 0; y <= n - kSsimWindow_px; ++y) {
            for (int x = 0; x <= n - kSsimWindow_px; ++x) {
                windows.add(ssim(ssim_window(a[face], x, y), ssim_window(b[face], x, y),
                                 ssim_window(c[face], x, y)));
            }
        }
    }
    return windows.mean();
}

class MediaBake : public testing::Test {
  protected:
    MediaBake() { scene_.media = Media({cloud(Rgb(0.1f), Rgb(0.9f)), haze()}); }

    Pilot pilot(const JobSpec& job) const {
        return run_pilot(scene_, job, make_plan(scene_, job), light_state(scene_, job, 0, cancel_),
                         cancel_);
    }
    ProbeResult bake(const JobSpec& job, const UnitParams& unit = {}) const {
        return bake_probe(scene_, job, pilot(job), unit, cancel_);
    }
    /// As a job's probes are baked: the first of them teach the pilot.
    std::vector<ProbeResult> bake_all(const JobSpec& job, Pilot& pilot) const {
        std::vector<ProbeResult> results;
        for (size_t i = 0; i < job.probes.size(); ++i) {
            const bool teaches = i < probes_to_learn_from(job);
            if (i == probes_to_learn_from(job)) learn(pilot, job.quality, results);
            results.push_back(
                bake_probe(scene_, job, pilot, {.probe = i, .teaches = teaches}, cancel_));
        }
        return results;
    }
    /// Of paths that no bake traces.
    Cubemap truth_of(const JobSpec& job, size_t probe, const Pilot& pilot, int paths,
                     uint64_t key) const {
        return render_through_media(scene_, *pilot.media->tracer,
                                    volume_view(scene_, job.probes[probe], key),
                                    {.kind = RendererKind::kPaths, .samples = paths}, {}, cancel_)
            .color;
    }
    static Cubemap cube_of(const ProbeResult& result) {
        return decode_cubemap(result.files[0].bytes, "").cubemap;
    }
    /// JSON pointer of the one thing that is wrong with a job.
    std::string refused(const Json& request) const {
        try {
            make_plan(scene_, read_job(request));
        } catch (const SpecError& error) {
            return error.issues().size() == 1 ? error.issues()[0].pointer : error.what();
        }
        return "";
    }

    Scene scene_ = test::small_scene();
    CancelToken cancel_;
};

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

/// A job of 48 probes, some of them within the cloud.
constexpr int kProbes = 48;
Json many_probes(Json request) {
    request["probes"]["list"].clear();
    for (int i = 0; i < kProbes; ++i) {
        const Vec3 p(-7.0 + 2.3 * (i % 4), 7.0 + 1.9 * (i / 4 % 3), 4.0 + 2.9 * (i / 12));
        request["probes"]["list"].push_back(
            {{"id", "p" + std::to_string(i)}, {"position_m", {p.x, p.y, p.z}}});
    }
    return request;
}

/// Against renders of a thousand paths in every pixel.
TEST_F(MediaBake, PromisesOfIrradianceHold) {
    constexpr double kIrradiance = 0.05;
    Json request = many_probes(day_request({{"irradiance_rel", kIrradiance}}));
    request["products"] = {"cube", "sh"};
    const JobSpec job = read_job(request);
    Pilot pilot = this->pilot(job);
    const std::vector<ProbeResult> results = bake_all(job, pilot);
    int kept = 0;
    int covered = 0;
    int within = 0;
    double paths = 0.0;
    double audit = 0.0;
    double render = 0.0;
    for (const ProbeResult& result : results) {
        EXPECT_TRUE(result.target_met);
        const ShRgb truth = project_sh(truth_of(job, result.probe, pilot, 1024, 1234));
        ShRgb difference = project_sh(cube_of(result));
        Vec3 squares(0.0);
        for (size_t k = 0; k < truth.size(); ++k) {
            difference[k] -= truth[k];
            squares += difference[k] * difference[k];
        }
        const double error = irradiance_norm(difference) / irradiance_norm(truth);
        const Interval& interval = result.pooled.front()->interval;
        kept += error <= kIrradiance ? 1 : 0;
        covered += error * error >= interval.low && error * error <= interval.high ? 1 : 0;
        const auto& bytes = result.files[1].bytes;
        const auto* text = reinterpret_cast<const char*>(bytes.data());
        const Json file = Json::parse(text, text + bytes.size());
        const double bound = file["error"]["irradiance_off_by_at_most"][0];
        within += kShLargestIrradiance * std::sqrt(squares.r) <= bound ? 1 : 0;
        EXPECT_NEAR(file["error"]["irradiance_rel_interval"][1], std::sqrt(interval.high), 1e-9);
        paths += static_cast<double>(result.render_cost().rays) / kProbes /
                 static_cast<double>(owned_pixel_count(kFace));
        render += static_cast<double>(result.render_cost().steps);
        audit += static_cast<double>(result.certificate.cost.steps + result.decision_cost.steps);
    }
    std::printf("of %d: %d kept, %d covered, %d within the bound; %.1f paths, audits %.3f\n",
                kProbes, kept, covered, within, paths, audit / render);
    // With 95 % kept, fewer than 41 of 48 would be by chance in 0.5 % of all cases.
    EXPECT_GE(kept, 41);
    EXPECT_GE(covered, 41);
    EXPECT_GE(within, 41);
    EXPECT_LT(paths, 60.0);
}

/// Against two renders of 128 paths in every pixel, whose noise does not count.
TEST_F(MediaBake, PromisesOfSsimHold) {
    constexpr double kSsim = 0.7;
    constexpr int kWindowFace = 14;
    Json request = many_probes(day_request({{"ssim", kSsim}}));
    request["face_size_px"] = kWindowFace;
    const JobSpec job = read_job(request);
    Pilot pilot = this->pilot(job);
    const std::vector<ProbeResult> results = bake_all(job, pilot);
    int kept = 0;
    int covered = 0;
    double paths = 0.0;
    double audit = 0.0;
    double render = 0.0;
    for (const ProbeResult& result : results) {
        EXPECT_TRUE(result.target_met);
        const double ssim =
            mean_ssim(cube_of(result), truth_of(job, result.probe, pilot, 128, 1234),
                      truth_of(job, result.probe, pilot, 128, 4321), pilot.exposure);
        const Interval& lost = result.pooled.front()->interval;
        kept += ssim >= kSsim ? 1 : 0;
        covered += 1.0 - ssim >= lost.low && 1.0 - ssim <= lost.high ? 1 : 0;
        paths += static_cast<double>(result.render_cost().rays) / kProbes /
                 static_cast<double>(owned_pixel_count(kWindowFace));
        render += static_cast<double>(result.render_cost().steps);
        audit += static_cast<double>(result.certificate.cost.steps + result.decision_cost.steps);
    }
    std::printf("of %d: %d kept, %d covered; %.1f paths, audits %.3f\n", kProbes, kept, covered,
                paths, audit / render);
    // With 95 % kept, fewer than 41 of 48 would be by chance in 0.5 % of all cases.
    EXPECT_GE(kept, 41);
    EXPECT_GE(covered, 41);
    EXPECT_LT(audit, 0.15 * render);
}

/// Its probes have faces of windows of SSIM, and learn from each other as the job's do.
TEST_F(MediaBake, ForecastsOfSsimAreMadeWithWindows) {
    Json request = many_probes(day_request({{"ssim", 0.5}}));
    request["face_size_px"] = 16;
    const JobSpec job = read_job(request);
    const Plan plan = make_plan(scene_, job);
    const Forecast forecast = make_forecast(scene_, job, plan, 2, cancel_);
    EXPECT_GT(forecast.seconds, 0.0);
    Pilot pilot = this->pilot(job);
    double bytes = 0.0;
    for (const ProbeResult& result : bake_all(job, pilot)) {
        bytes += static_cast<double>(result.files.front().size_bytes);
    }
    EXPECT_NEAR(static_cast<double>(forecast.output_bytes) / bytes, 1.0, 0.25);
}

TEST_F(MediaBake, CurveOfIrradianceTellsWhatCubemapsAreWrongBy) {
    const JobSpec job = read_job(day_request({{"irradiance_rel", 0.1}}));
    const Pilot pilot = this->pilot(job);
    ASSERT_EQ(pilot.curve.size(), 5u);
    const CurvePoint& point = pilot.curve[2];
    ASSERT_TRUE(point.error.irradiance_square);
    // Half the squared difference of two independent renders of the same probe.
    constexpr uint64_t kPairs = 8;
    Moments squares;
    for (const ProbeSpec& probe : job.probes) {
        for (uint64_t pair = 0; pair < kPairs; ++pair) {
            const auto sh = [&](uint64_t key) {
                return project_sh(render_through_media(scene_, *pilot.media->tracer,
                                                       volume_view(scene_, probe, key),
                                                       point.settings, {}, cancel_)
                                      .color);
            };
            const ShRgb one = sh(2 * pair + 1);
            ShRgb difference = sh(2 * pair + 2);
            for (size_t i = 0; i < one.size(); ++i) difference[i] -= one[i];
            const double relative = irradiance_norm(difference) / irradiance_norm(one);
            squares.add(relative * relative / 2.0);
        }
    }
    const Estimate found = Estimate::of_mean(squares);
    const Interval predicted = point.error.irradiance_square->interval(0.99);
    std::printf("%d paths: predicted %.5f, found %.5f\n", point.settings.samples,
                std::sqrt(point.error.irradiance_square->value), std::sqrt(found.value));
    EXPECT_LT(found.interval(0.99).low, predicted.high);
    EXPECT_GT(found.interval(0.99).high, predicted.low);
    EXPECT_LT(predicted.high, 4.0 * predicted.low);
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
