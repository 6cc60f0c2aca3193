#include "bake/bake_probe.h"
#include "bake/learn.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <map>
#include <string_view>

#include "bake/audit_size.h"
#include "bake/bake_fixture.h"
#include "bake/report.h"
#include "image/exr.h"
#include "image/metrics.h"
#include "io/sha256.h"
#include "render/render.h"

namespace probebake {
namespace {

class BakeProbeTest : public testing::Test {
  protected:
    ProbeResult bake(const JobSpec& job, const UnitParams& unit = {},
                     const LightingState& state = LightingState::kAlbedo) const {
        const Pilot pilot = run_pilot(scene_, job, make_plan(scene_, job), state, cancel_);
        return bake_probe(scene_, job, pilot, unit, cancel_);
    }

    Scene scene_ = test::small_scene();
    CancelToken cancel_;
};

TEST_F(BakeProbeTest, TheFileSaysOfItsErrorWhatItsRowSays) {
    bool looked_again = false;
    for (const char* renderer : {"hybrid", "error_aware"}) {  // with a posterior and without
        for (const double psnr_db : {24.0, 30.0, 36.0}) {
            Json request = test::small_request(2, {{"psnr_db", psnr_db}});
            request["quality"]["renderer"] = renderer;
            request["quality"]["evidence"]["pixels_per_probe"] = 20;  // too few for one look
            request["products"] = {"cube", "sh"};
            const JobSpec job = read_job(request);
            const Plan plan = make_plan(scene_, job);
            const std::vector<Pilot> pilots = {
                run_pilot(scene_, job, plan, LightingState::kAlbedo, cancel_)};
            const std::vector<ProbeResult> results = {
                bake_probe(scene_, job, pilots[0], {.probe = 1}, cancel_)};
            const ProbeResult& result = results[0];
            const BakeRecord record{
                .scene = scene_, .job = job, .plan = plan, .pilots = pilots, .results = results};
            const Json row =
                write_probe_row(record, pilots[0], result, result.certificate.error)["error"];
            const std::map<std::string, double>& numbers =
                decode_cubemap(result.files[0].bytes, "").attributes.numbers;
            EXPECT_EQ(numbers.at("probe:err:confidence"), row["confidence"]);
            EXPECT_EQ(numbers.at("probe:err:rmse"), row["rmse"]);
            EXPECT_EQ(numbers.at("probe:err:rmseLow"), row["rmse_interval"][0]);
            EXPECT_EQ(numbers.at("probe:err:rmseHigh"), row["rmse_interval"][1]);
            const std::vector<std::byte>& bytes = result.files[1].bytes;
            const Json sh = Json::parse(std::string_view(
                reinterpret_cast<const char*>(bytes.data()), bytes.size()))["error"];
            EXPECT_EQ(sh["confidence"], row["confidence"]);
            EXPECT_EQ(sh["irradiance_rel_interval"], row["irradiance_rel_interval"]);
            looked_again = looked_again || (result.looks > 1 && !result.pooled[0]);
        }
    }
    EXPECT_TRUE(looked_again) << "looks have their own confidence from the second on";
}

TEST_F(BakeProbeTest, TheFileHoldsTheCubemapAndWhatIsKnownOfIt) {
    Json request = test::small_request();
    request["products"] = {"cube", "aux"};
    request["near_m"] = 0.25;
    const JobSpec job = read_job(request);
    const ProbeResult result = bake(job, {.probe = 1});
    ASSERT_EQ(result.files.size(), 2u);
    EXPECT_EQ(result.files[0].name, "cube.exr");
    EXPECT_EQ(result.files[0].sha256, sha256_hex(result.files[0].bytes));
    EXPECT_EQ(result.files[0].size_bytes, result.files[0].bytes.size());

    const DecodedCubemap cube = decode_cubemap(result.files[0].bytes, "cube.exr");
    const ProbeAttributes& attributes = cube.attributes;
    EXPECT_EQ(attributes.id, "p1");
    EXPECT_EQ(attributes.state, "albedo");
    EXPECT_EQ(attributes.unit, "1");
    EXPECT_EQ(attributes.position_m, job.probes[1].position_m);
    EXPECT_EQ(attributes.near_m, 0.25);
    EXPECT_EQ(attributes.far_m, result.far_m);
    EXPECT_EQ(attributes.scene_sha256, scene_.sha256);
    EXPECT_EQ(attributes.seed, 7u);
    EXPECT_TRUE(attributes.valid);
    const PooledError& known = *result.pooled.front();
    EXPECT_NEAR(attributes.numbers.at("probe:err:rmse"), std::sqrt(known.value), 1e-12);
    EXPECT_NEAR(attributes.numbers.at("probe:err:rmseHigh"), std::sqrt(known.interval.high), 1e-12);
    EXPECT_EQ(attributes.texts.at("probe:err:evidence"), name_of(result.evidence));
    EXPECT_EQ(attributes.numbers.at("probe:err:pixels"),
              static_cast<double>(result.certificate.pixels));

    const RenderScene what = render_scene(scene_, job.probes[1], LightingState::kAlbedo);
    const CubemapRender expected = render_cubemap(what, scene_.to_voxels(job.probes[1].position_m),
                                                  16, result.settings, cancel_);
    EXPECT_TRUE(cube.cubemap == rounded_to_file(expected.color));
    EXPECT_EQ(result.render_cost().steps, expected.total().steps);

    const CubeAux aux = decode_aux(result.files[1].bytes, "aux.exr").aux;
    ASSERT_EQ(aux.pixels.size(), expected.aux.size());
    for (size_t i = 0; i < aux.pixels.size(); ++i) {
        EXPECT_NEAR(aux.pixels[i].z_m, expected.aux[i].distance * 0.25f, 1e-4f);
        EXPECT_EQ(static_cast<float>(aux.pixels[i].samples), expected.aux[i].samples);
        EXPECT_LE(aux.pixels[i].z_m, static_cast<float>(result.far_m) * 1.0001f);
    }
}

TEST_F(BakeProbeTest, TheSameBytesForAnyNumberOfThreads) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    Json request = test::small_request();
    request["products"] = {"cube", "aux"};
    const JobSpec job = read_job(request);
    const Pilot pilot =
        run_pilot(scene_, job, make_plan(scene_, job), LightingState::kAlbedo, cancel_);
    const ProbeResult one = bake_probe(scene_, job, pilot, {.probe = 0}, cancel_);
    for (const int threads : {1, 2, 7}) {
        tbb::task_arena arena(threads);
        ProbeResult many;
        arena.execute([&] { many = bake_probe(scene_, job, pilot, {.probe = 0}, cancel_); });
        ASSERT_EQ(many.files.size(), one.files.size());
        for (size_t i = 0; i < one.files.size(); ++i) {
            EXPECT_EQ(many.files[i].sha256, one.files[i].sha256) << threads;
        }
    }
}

TEST_F(BakeProbeTest, AProbeThatMissesTheTargetIsRefinedFurther) {
    // A pilot that was far too hopeful.
    const JobSpec job = test::small_job(2, {{"psnr_db", 30.0}});
    Pilot pilot = run_pilot(scene_, job, make_plan(scene_, job), LightingState::kAlbedo, cancel_);
    const RenderSettings good = pilot.settings;
    pilot.steering.clear();
    pilot.settings = {.kind = RendererKind::kLod};
    pilot.settings_mse = pilot.curve.front().error.mse.value;
    pilot.finer.insert(pilot.finer.begin(), {good, std::pow(10.0, -3.0)});
    const ProbeResult result = bake_probe(scene_, job, pilot, {.probe = 0}, cancel_);
    EXPECT_GE(result.looks, 2);
    EXPECT_GT(result.earlier_renders.rays, 0u);
    EXPECT_GT(result.decision_cost.rays, 0u);
    EXPECT_FALSE(result.settings == pilot.settings);
    EXPECT_LT(result.certificate.error.mse.value, 2e-3);
}

TEST_F(BakeProbeTest, LimitsHold) {
    Json request = test::small_request(2, {{"psnr_db", 50.0}});
    request["budget"]["rays"] = 20'000;
    const JobSpec budget = read_job(request);
    const ProbeResult limited = bake(budget, {.probe = 1});
    EXPECT_LE(limited.render_cost().all_rays(), 10'000u);
    EXPECT_EQ(limited.looks, 1);
    const JobSpec rays = test::small_job(2, {{"rays", 9'000}});
    EXPECT_LE(bake(rays).render_cost().all_rays(), 9'000u);
    EXPECT_EQ(ray_limit(rays, rays.probes[0]), 9'000u);
    EXPECT_FALSE(ray_limit(test::small_job(), test::small_job().probes[0]));

    const ProbeResult late = bake(test::small_job(), {.probe = 0, .out_of_time = true});
    EXPECT_EQ(late.settings.kind, RendererKind::kLod);
    EXPECT_TRUE(late.limited);
}

TEST_F(BakeProbeTest, WithoutEvidenceNothingIsAudited) {
    Json request = test::small_request();
    request["quality"]["evidence"] = {{"audit", false}};
    const ProbeResult result = bake(read_job(request));
    EXPECT_EQ(result.certificate.pixels, 0u);
    EXPECT_EQ(result.decision_cost.rays, 0u);
    const DecodedCubemap cube = decode_cubemap(result.files[0].bytes, "cube.exr");
    EXPECT_FALSE(cube.attributes.numbers.contains("probe:err:rmse"));
}

TEST_F(BakeProbeTest, EmissionIsASeparateState) {
    // Two walls: one reflects, one emits 2^20.
    VoxelCloud cloud{.emission_scale = 1048576.0f, .depth = 4};
    for (int a = 0; a < 16; ++a) {
        for (int b = 0; b < 16; ++b) {
            cloud.voxels.push_back(make_voxel({12, a, b}, pack_rgb(Rgb(0.5f))));
            cloud.voxels.push_back(
                make_voxel({a, 15, b}, pack_rgb(Rgb(0.25f)), pack_rgb(Rgb(1.0f)), 1));
        }
    }
    scene_.tree = VoxelTree::build(cloud);
    Json request = test::small_request(1);
    const Vec3 p = scene_.to_metres(Vec3(4.5, 4.5, 4.5));
    request["probes"]["list"][0]["position_m"] = {p.x, p.y, p.z};
    request["lighting_states"] = {"albedo", "emission"};
    request["face_size_px"] = 8;
    const JobSpec job = read_job(request);
    const auto brightest = [&](const LightingState& state) {
        const ProbeResult result = bake(job, {}, state);
        EXPECT_EQ(result.is_float, state == LightingState::kEmission);
        float most = 0.0f;
        const Cubemap cube = decode_cubemap(result.files[0].bytes, "").cubemap;
        for (const Rgb& pixel : cube.image().pixels()) most = std::max(most, pixel.g);
        return most;
    };
    EXPECT_EQ(brightest(LightingState::kAlbedo), 0.5f);
    EXPECT_EQ(brightest(LightingState::kEmission), 1048576.0f);  // a 1e6 emitter survives
}

TEST_F(BakeProbeTest, IrradianceDrawsGrowWithTheCube) {
    JobSpec job;
    EXPECT_EQ(irradiance_draws(job, 16).least, 64);
    EXPECT_EQ(irradiance_draws(job, 16).most, 1536);
    EXPECT_EQ(irradiance_draws(job, 64).least, 245);
    EXPECT_EQ(irradiance_draws(job, 64).most, 24'576);
    EXPECT_EQ(irradiance_draws(job, 1).most, 64);
    job.probes.resize(100);
    EXPECT_EQ(irradiance_draws(job, 4).least, 8);
}

TEST(AuditSize, WindowsOfSsimCostWhatTheRenderDoes) {
    const WindowDraws alone = ssim_windows({.rays_per_pixel = 1.0}, 0.0);
    EXPECT_EQ(alone.count, 16);
    EXPECT_EQ(alone.grid, 2);
    // Two windows of 2 × 9 × 121 rays where a quarter of that may be spent: in one probe of four.
    int count = 0;
    for (size_t probe = 0; probe < 4000; ++probe) {
        const WindowDraws spared = ssim_windows(
            {.rays_per_pixel = 20.0, .pooled = true, .lot = audit_lot(1, probe)}, 9.0 * 121.0);
        EXPECT_EQ(spared.grid, 3);
        EXPECT_EQ(spared.count % 2, 0);
        count += spared.count;
    }
    EXPECT_NEAR(count / 4000.0, 0.5, 0.01);
    const WindowDraws many = ssim_windows({.rays_per_pixel = 100.0, .pooled = true}, 100'000.0);
    EXPECT_EQ(many.grid, 4);
    EXPECT_NEAR(many.count, 1e5 / (2 * 16 * 121), 2.0);
}

TEST_F(BakeProbeTest, ASteeredProbeIsRefinedUntilItsBoundMeetsTheTarget) {
    const JobSpec job = test::small_job(2, {{"psnr_db", 32.0}});
    Pilot pilot = run_pilot(scene_, job, make_plan(scene_, job), LightingState::kAlbedo, cancel_);
    ASSERT_TRUE(pilot.steering.front());
    // Far too hopeful: it thinks that errors are a twentieth of what they are.
    pilot.steering.front()->goal *= 20.0;
    const ProbeResult result = bake_probe(scene_, job, pilot, {.probe = 0}, cancel_);
    EXPECT_GE(result.looks, 2);
    EXPECT_TRUE(result.target_met);
    EXPECT_EQ(result.earlier_renders.rays, 0u) << "refined, not rendered again";
    EXPECT_GT(result.decision_cost.rays, 0u);
    EXPECT_LE(result.pooled.front()->upper, std::pow(10.0, -3.2));
    // The bytes are those of its price, however it came to it.
    const RenderScene what = render_scene(scene_, job.probes[0], LightingState::kAlbedo);
    const CubemapRender expected = render_cubemap(what, scene_.to_voxels(job.probes[0].position_m),
                                                  16, result.settings, cancel_);
    EXPECT_TRUE(decode_cubemap(result.files[0].bytes, "cube.exr").cubemap ==
                rounded_to_file(expected.color));
    EXPECT_EQ(result.render_cost().steps, expected.total().steps);
}

TEST_F(BakeProbeTest, WhatPredictionsDoNotReachIsReachedByRaysInEveryPixel) {
    const JobSpec job = test::small_job(2, {{"psnr_db", 36.0}});
    Pilot pilot = run_pilot(scene_, job, make_plan(scene_, job), LightingState::kAlbedo, cancel_);
    ASSERT_FALSE(pilot.steering.empty());
    pilot.steering.front()->goal *= 1e5;  // nowhere near, step by step
    const ProbeResult result = bake_probe(scene_, job, pilot, {.probe = 0}, cancel_);
    EXPECT_TRUE(result.target_met);
    EXPECT_GE(result.looks, 4);
    EXPECT_GE(result.settings.least_grid, 4);
    EXPECT_EQ(write_settings(result.settings)["least_grid"], result.settings.least_grid);
    EXPECT_GE(result.render_cost().all_rays(), 16 * owned_pixel_count(16));
}

TEST_F(BakeProbeTest, RelativeErrorIsATarget) {
    const JobSpec job = test::small_job(1, {{"rel_mse", 0.01}});
    const ProbeResult result = bake(job);
    EXPECT_TRUE(result.target_met);
    const RenderScene what = render_scene(scene_, job.probes[0], LightingState::kAlbedo);
    const Cubemap truth =
        render_cubemap(what, scene_.to_voxels(job.probes[0].position_m), 16,
                       {.kind = RendererKind::kReference, .leaf_grid = 32}, cancel_)
            .color;
    const Cubemap cube = decode_cubemap(result.files[0].bytes, "cube.exr").cubemap;
    EXPECT_LT(*compare_cubemaps(cube, truth, 1.0).cube.rel_mse, 0.01);
}

// The audits of 100 probes and more cost less than 15 % of their render.
TEST_F(BakeProbeTest, AuditAndPilotAreASmallShareOfALargeJob) {
    const JobSpec job = test::small_job(8, {{"psnr_db", 32.0}});
    Pilot pilot = run_pilot(scene_, job, make_plan(scene_, job), LightingState::kAlbedo, cancel_);
    CostStats render;
    CostStats audit;
    std::vector<ProbeResult> first;
    for (size_t i = 0; i < 8; ++i) {
        first.push_back(bake_probe(scene_, job, pilot, {.probe = i, .teaches = true}, cancel_));
    }
    learn(pilot, job.quality, first);
    for (size_t i = 0; i < 8; ++i) {
        const ProbeResult result = bake_probe(scene_, job, pilot, {.probe = i}, cancel_);
        render += result.render_cost();
        audit += result.certificate.cost;
        audit += result.decision_cost;
    }
    EXPECT_LT(static_cast<double>(audit.steps), 0.15 * static_cast<double>(render.steps));
}

}  // namespace
}  // namespace probebake
