// Spherical harmonics as a product and as a target.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "bake/report.h"
#include "bake/sh_file.h"
#include "image/exr.h"

namespace probebake {
namespace {

class ShTest : public testing::Test {
  protected:
    Pilot pilot(const JobSpec& job) const {
        return run_pilot(scene_, job, make_plan(scene_, job), LightingState::kAlbedo, cancel_);
    }
    ProbeResult bake(const JobSpec& job) const {
        return bake_probe(scene_, job, pilot(job), {.probe = 0}, cancel_);
    }
    static Json sh_of(const ProbeResult& result) {
        const auto file = std::find_if(result.files.begin(), result.files.end(),
                                       [](const ProductFile& f) { return f.name == "sh.json"; });
        return Json::parse(
            std::string(reinterpret_cast<const char*>(file->bytes.data()), file->bytes.size()));
    }
    static JobSpec sh_job(double target, int probes = 2) {
        Json request = test::small_request(probes, {{"irradiance_rel", target}});
        request["products"] = {"sh"};
        return read_job(request);
    }

    Scene scene_ = test::small_scene();
    CancelToken cancel_;
};

// 300 audits of one cubemap against the differences from a truth of 32 × 32 rays per pixel: no
// coefficient is biased by more than 4.5 standard errors (27 of them), intervals of 95 % cover
// in at least 91 % (300 runs see 90 %), and would not cover an error that is 2.5 times as
// large.
TEST_F(ShTest, TheAuditEstimatesTheDifferencesAndItsIntervalsCover) {
    const JobSpec job = test::small_job(1);
    const RenderScene what = render_scene(scene_, job.probes[0], LightingState::kAlbedo);
    const Vec3 origin = scene_.to_voxels(job.probes[0].position_m);
    const auto render = [&](const RenderSettings& settings) {
        return render_cubemap(what, origin, 16, settings, cancel_);
    };
    const ShRgb truth =
        project_sh(render({.kind = RendererKind::kReference, .leaf_grid = 32}).color);
    struct Case {
        RenderSettings settings;
        bool drawn_for_sh;
        int truth_grid;
        int pixels;
    };
    for (const Case& c : {Case{{.kind = RendererKind::kReference, .leaf_grid = 1}, true, 1, 2000},
                          Case{{.kind = RendererKind::kLod}, false, 4, 200}}) {
        const CubemapRender cube = render(c.settings);
        const Cubemap as_written = rounded_to_file(cube.color);
        const ShRgb radiance = project_sh(as_written);
        ShRgb difference;
        for (size_t i = 0; i < difference.size(); ++i) difference[i] = radiance[i] - truth[i];
        const double expected = irradiance_norm(difference) / irradiance_norm(radiance);
        constexpr int kRuns = 300;
        std::array<Moments, 27> moments;
        int covered = 0;
        int channels_covered = 0;
        int covered_larger = 0;
        double high = 0.0;
        for (uint64_t run = 0; run < kRuns; ++run) {
            const Audit audit = audit_cubemap({.truth = voxel_truth(what, origin, 16),
                                               .as_written = as_written,
                                               .aux = cube.aux,
                                               .truth_grid = c.truth_grid,
                                               .pixels = c.pixels,
                                               .sh = true,
                                               .drawn_for_sh = c.drawn_for_sh,
                                               .key = random_key({run, 17})},
                                              cancel_);
            for (size_t i = 0; i < moments.size(); ++i) {
                moments[i].add(audit.sh->difference[i / 3][static_cast<int>(i % 3)]);
            }
            const Interval interval = audit.error.irradiance->interval(0.95);
            covered += interval.low <= expected && expected <= interval.high ? 1 : 0;
            covered_larger += 2.5 * expected + 0.1 <= interval.high ? 1 : 0;
            high += interval.high / kRuns;
            double green2 = 0.0;
            for (const Vec3& d : difference) green2 += d.g * d.g;
            const Interval green = audit.sh->channels[1].interval(0.95);
            channels_covered += std::sqrt(green2) <= green.high ? 1 : 0;
        }
        std::printf("irradiance_rel %.4f: mean upper end %.4f, covered %d of %d\n", expected, high,
                    covered, kRuns);
        for (size_t i = 0; i < moments.size(); ++i) {
            const Estimate mean = Estimate::of_mean(moments[i]);
            EXPECT_NEAR(mean.value, difference[i / 3][static_cast<int>(i % 3)],
                        4.5 * mean.standard_error() + 1e-4)
                << i;
        }
        EXPECT_GT(covered, 0.91 * kRuns);
        EXPECT_GT(channels_covered, 0.94 * kRuns);
        EXPECT_LT(covered_larger, 0.2 * kRuns);
    }
}

TEST_F(ShTest, TheFileSaysWhatItHoldsAndHowWrongItIs) {
    Json request = test::small_request(1);
    request["products"] = {"cube", "sh"};
    const JobSpec job = read_job(request);
    const ProbeResult both = bake(job);
    ASSERT_EQ(both.files.size(), 2U);
    const Json sh = sh_of(both);
    EXPECT_EQ(sh["basis"], "real, orthonormal, no Condon-Shortley sign");
    EXPECT_EQ(sh["unit"], "1");
    EXPECT_EQ(sh["probe"], "p0");
    EXPECT_EQ(sh["coefficients"][2], "L10");
    const ShRgb radiance = project_sh(decode_cubemap(both.files[0].bytes, "cube.exr").cubemap);
    for (size_t i = 0; i < radiance.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            EXPECT_EQ(sh["rgb"][i][static_cast<size_t>(c)].get<double>(), radiance[i][c]);
            EXPECT_GT(sh["error"]["standard_error"][i][static_cast<size_t>(c)], 0.0);
        }
    }
    EXPECT_LT(sh["error"]["irradiance_rel_interval"][0], sh["error"]["irradiance_rel_interval"][1]);
    EXPECT_GT(sh["error"]["irradiance_off_by_at_most"][1], 0.0);

    // The cube is the same without it, and it is the same without the cube.
    request["products"] = {"cube"};
    EXPECT_EQ(bake(read_job(request)).files[0].sha256, both.files[0].sha256);
    request["products"] = {"sh"};
    const ProbeResult alone = bake(read_job(request));
    ASSERT_EQ(alone.files.size(), 1U);
    EXPECT_EQ(alone.files[0].sha256, both.files[1].sha256);

    request["quality"]["evidence"] = {{"audit", false}};
    EXPECT_FALSE(sh_of(bake(read_job(request))).contains("error"));
}

TEST_F(ShTest, OtherLayoutsAreFilesOfTheirOwn) {
    Json request = test::small_request(1, {{"rays", 20'000}});
    request["products"] = {"latlong", "gl_faces"};
    request["lighting_states"] = {"albedo"};
    const ProbeResult result = bake(read_job(request));
    std::vector<std::string> names;
    for (const ProductFile& file : result.files) names.push_back(file.name);
    EXPECT_EQ(names, (std::vector<std::string>{"latlong.exr", "px.exr", "nx.exr", "py.exr",
                                               "ny.exr", "pz.exr", "nz.exr"}));
    EXPECT_FALSE(result.is_float);
    EXPECT_EQ(bake(read_job(request)).files[0].sha256, result.files[0].sha256);
    // The primary file's reader takes neither of them for a cube.
    for (const ProductFile& file : result.files) {
        EXPECT_THROW(decode_cubemap(file.bytes, file.name), IoError) << file.name;
    }
}

TEST_F(ShTest, IrradianceBeginsWithOneLeafRayPerPixel) {
    const JobSpec job = sh_job(0.5);
    const Plan plan = make_plan(scene_, job);
    EXPECT_EQ(plan.renderers, std::vector{RendererKind::kReference});
    EXPECT_FALSE(plan.needs_pilot);
    EXPECT_FALSE(plan.needs_error_table);
    for (const char* what :
         {"quality search", "refinement ladder", "LOD colours", "cube file", "error table"}) {
        EXPECT_TRUE(std::any_of(plan.left_out.begin(), plan.left_out.end(),
                                [&](const LeftOut& left) { return left.what == what; }))
            << what;
    }
    const Pilot pilot = this->pilot(job);
    // In each of the sample's 384 pixels two rays of truth, for the exposure, and, for the
    // curve, twice 1 + 4 + 9 + 16 + 64 leaf rays; the irradiance seen from both probes, by 8 × 8
    // pixels a face.
    constexpr uint64_t kPixels = 384;
    EXPECT_EQ(pilot.curve.size(), 5U);
    EXPECT_EQ(pilot.curve_cost.all_rays(), 94 * kPixels);
    EXPECT_EQ(pilot.search_cost.all_rays(), (2 + 94) * kPixels + 2 * uint64_t{384});
    const ProbeResult result = bake_probe(scene_, job, pilot, {.probe = 0}, cancel_);
    EXPECT_EQ(
        result.settings,
        (RenderSettings{.kind = RendererKind::kReference, .leaf_grid = 1, .shifted_grid = true}));
    EXPECT_EQ(result.render_cost().all_rays(), owned_pixel_count(16));
    EXPECT_EQ(result.render_cost().level_histogram[0], result.render_cost().hits());
    const MeasuredError& own = result.certificate.error;
    EXPECT_EQ(judge(job, pilot, result, own).verdict, Verdict::kTargetMet);

    Json request = test::small_request(1, {{"irradiance_rel", 0.5}});
    request["quality"]["exposure"] = 0.5;
    EXPECT_EQ(this->pilot(read_job(request)).search_cost.all_rays(), 94 * kPixels + 384);
}

TEST_F(ShTest, AProbeWhoseBoundMissesTheTargetGetsFinerGrids) {
    const JobSpec job = sh_job(0.03);
    const Pilot pilot = this->pilot(job);
    const ProbeResult result = bake_probe(scene_, job, pilot, {.probe = 0}, cancel_);
    EXPECT_GE(result.looks, 2);
    EXPECT_GT(result.settings.leaf_grid, 1);
    const Interval bound = result.certificate.error.irradiance->interval(0.95);
    std::printf("grid %d: irradiance_rel at most %.4f\n", result.settings.leaf_grid, bound.high);
    EXPECT_LT(bound.high, 0.045);
    // What nothing reaches is said to be out of reach.
    const JobSpec hopeless = sh_job(1e-6);
    const Pilot other = this->pilot(hopeless);
    const ProbeResult finest = bake_probe(scene_, hopeless, other, {.probe = 0}, cancel_);
    EXPECT_EQ(finest.settings.leaf_grid, 16);
    EXPECT_EQ(judge(hopeless, other, finest, finest.certificate.error).verdict,
              Verdict::kUnreachable);
    // A limit of rays is kept, and the verdict says that it stood in the way.
    JobSpec limited = sh_job(0.001);
    limited.budget.rays = uint64_t{2} * 5 * owned_pixel_count(16);
    const ProbeResult poor = bake_probe(scene_, limited, other, {.probe = 0}, cancel_);
    EXPECT_LE(poor.render_cost().all_rays(), 5 * owned_pixel_count(16));
    EXPECT_EQ(judge(limited, other, poor, poor.certificate.error).verdict,
              Verdict::kBudgetExhausted);
}

TEST_F(ShTest, TheSameBytesForAnyNumberOfThreads) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    const JobSpec job = sh_job(0.1);
    std::string sha256;
    for (const int threads : {1, 2, 7}) {
        tbb::task_arena arena(threads);
        ProbeResult result;
        arena.execute([&] { result = bake(job); });
        ASSERT_EQ(result.files.size(), 1U);
        if (sha256.empty()) sha256 = result.files[0].sha256;
        EXPECT_EQ(result.files[0].sha256, sha256) << threads;
    }
}

TEST_F(ShTest, NothingIsPromisedOfABlackFile) {
    const ShRgb black{};
    const std::vector<ShDraw> none(10, ShDraw{{CubeFace::kPosY, 3, 3}, Vec3(0.0)});
    EXPECT_TRUE(relative_irradiance(audit_sh(none, 8), black).nothing_found());
    std::vector<ShDraw> some = none;
    some[2].difference = Vec3(-1.0);
    const NormEstimate error = relative_irradiance(audit_sh(some, 8), black);
    EXPECT_FALSE(error.interval(0.95).high <= 1.0);
    const NormEstimate unseen = relative_irradiance(audit_sh(none, 8, {2.0, 1000}), black);
    EXPECT_EQ(unseen.interval(0.95).low, 0.0);
    EXPECT_EQ(unseen.interval(0.95).high, std::numeric_limits<double>::infinity());
}

/// A file of radiance 1 everywhere, of which nothing differed: if the share that 1,000 rays may all
/// have missed were lit by 3 more.
TEST_F(ShTest, WhatMayLieUnseenIsNotProvenAway) {
    const std::vector<ShDraw> none(10, ShDraw{{CubeFace::kPosY, 3, 3}, Vec3(0.0)});
    const ShAudit audit = audit_sh(none, 8, {3.0, 1000});
    Cubemap ones(8);
    for (size_t i = 0; i < size_t{6} * 8 * 8; ++i) ones.at(pixel_at(i, 8)) = Rgb(1.0f);
    const double share = unseen_share(1000, 0.95);
    EXPECT_NEAR(relative_irradiance(audit, project_sh(ones)).interval(0.95).high,
                3.0 * share * 4.0 * kShLargestIrradiance / std::sqrt(4.0 * std::numbers::pi),
                1e-3 * share);
    // Of all normals, the one towards it: at most E = L · Ω · (A · Y)² summed.
    EXPECT_NEAR(
        kShLargestIrradiance * audit.channels[1].interval(0.95).high,
        std::sqrt(3.0) * 3.0 * share * kShLargestIrradiance * 6.0 * std::sqrt(std::numbers::pi),
        1e-9);
}

TEST_F(ShTest, RequestsForIrradiance) {
    const JobSpec job = sh_job(0.02);
    EXPECT_FALSE(job.products.cube);
    const Json written = write_job(job);
    EXPECT_EQ(written["products"], Json{"sh"});
    EXPECT_EQ(written["quality"]["targets"], (Json{{"irradiance_rel", 0.02}}));
    EXPECT_EQ(write_job(read_job(written)), written);
    // Spherical harmonics alone are for irradiance unless something else is asked for.
    Json request = test::small_request();
    request["products"] = {"sh"};
    request["quality"].erase("targets");
    EXPECT_EQ(read_job(request).quality.targets.front().metric,
              QualityTarget::Metric::kIrradianceRel);
    request["products"] = {"cube", "sh"};
    EXPECT_EQ(read_job(request).quality.targets.front().metric, QualityTarget::Metric::kPsnrDb);
    request["quality"] = {{"targets", {{"irradiance_rel", 0.02}}}, {"renderer", "hybrid"}};
    EXPECT_THROW(read_job(request), SpecError);
    request["quality"]["settings"] = {{"price", 0.1}};
    EXPECT_EQ(make_plan(scene_, read_job(request)).renderers, std::vector{RendererKind::kHybrid});
}

}  // namespace
}  // namespace probebake
