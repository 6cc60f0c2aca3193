#include "bake/report.h"

#include "bake/bake_probe.h"
#include "bake/state_error.h"

#include <gtest/gtest.h>

#include "bake/bake_fixture.h"

namespace probebake {
namespace {

Estimate estimate(double value, double standard_error) {
    return {.value = value,
            .variance = standard_error * standard_error,
            .third_moment = 0.0,
            .samples = 100,
            .degrees_of_freedom = 99};
}

TEST(Judge, OwnEvidenceFirstThenTheJobs) {
    const JobSpec job = test::small_job(2, {{"psnr_db", 40.0}});  // mean squared error 1e-4
    Pilot pilot;
    pilot.finer = {{{.threshold = 0.0}, 1e-5}};
    ProbeResult result;
    result.certificate.pixels = 100;
    const MeasuredError good{estimate(0.5e-4, 1e-6), {}};
    const MeasuredError bad{estimate(2e-4, 1e-6), {}};
    const MeasuredError vague{estimate(0.9e-4, 0.5e-4), {}};
    const auto judge_own = [&](const MeasuredError& own, const MeasuredError& pooled) {
        result.certificate.error = own;
        result.target_met = bound_meets(job.quality, own, 0.95);
        result.evidence = EvidenceOf::kProbe;
        return judge(job, pilot, result, pooled);
    };
    EXPECT_EQ(judge_own(good, bad).verdict, Verdict::kTargetMet);
    EXPECT_EQ(judge_own(good, bad).evidence, EvidenceOf::kProbe);
    EXPECT_EQ(judge_own(vague, good).verdict, Verdict::kTargetMet);
    EXPECT_EQ(judge_own(vague, good).evidence, EvidenceOf::kJob);
    EXPECT_EQ(judge_own(vague, vague).verdict, Verdict::kTargetMissed);
    // What the probe itself disproves, or only misses by its own estimate, no other can save.
    EXPECT_EQ(judge_own(bad, good).verdict, Verdict::kTargetMissed);
    const MeasuredError a_little{estimate(1.1e-4, 0.5e-4), {}};
    EXPECT_EQ(judge_own(a_little, good).verdict, Verdict::kTargetMissed);
    // Nor where the job's evidence has been asked already, probe by probe.
    result.first_look = {AuditedRatio{}};
    EXPECT_EQ(judge_own(vague, good).verdict, Verdict::kTargetMissed);
    result.first_look.clear();
    EXPECT_EQ(judge_own(bad, good).verdict, Verdict::kTargetMissed);
    result.settings = pilot.finer.back().settings;
    EXPECT_EQ(judge_own(bad, good).verdict, Verdict::kUnreachable);
    result.limited = true;
    EXPECT_EQ(judge_own(bad, good).verdict, Verdict::kBudgetExhausted);
    EXPECT_EQ(judge_own(good, bad).verdict, Verdict::kTargetMet);
    result.limited = false;
    result.certificate.pixels = 0;
    // Whose own audit was spared, and nothing was audited at all.
    EXPECT_EQ(judge_own({}, good).verdict, Verdict::kTargetMet);
    EXPECT_EQ(judge_own({}, good).evidence, EvidenceOf::kJob);
    EXPECT_EQ(judge_own({}, bad).verdict, Verdict::kUnreachable);
    EXPECT_EQ(judge_own({}, {}).verdict, Verdict::kNotAudited);
    EXPECT_EQ(judge(test::small_job(2, {{"rays", 9000}}), pilot, result, good).verdict,
              Verdict::kTargetMet);
}

TEST(Judge, WhatAllLeafRaysMissIsUnreachable) {
    const Scene scene = test::small_scene();
    const CancelToken cancel;
    JobSpec job = test::small_job(1, {{"psnr_db", 30.0}});
    job.probes[0].face_size_px = 8;
    Pilot pilot = run_pilot(scene, job, make_plan(scene, job), LightingState::kAlbedo, cancel);
    ASSERT_EQ(pilot.expectation, Expectation::kTargetMet);
    // The probe is harder than any that the pilot looked at.
    job.quality.targets[0].value = 150.0;
    pilot.steering = {steering_of(job.quality.targets[0], pilot.steering[0]->prior)};
    const ProbeResult result = bake_probe(scene, job, pilot, {}, cancel);
    EXPECT_EQ(result.settings.least_grid, 16);
    EXPECT_EQ(judge(job, pilot, result, result.certificate.error).verdict, Verdict::kUnreachable);
}

TEST(Report, AddsUpAndStatesItsEvidence) {
    const Scene scene = test::small_scene();
    const CancelToken cancel;
    const JobSpec job = test::small_job(3, {{"psnr_db", 26.0}});
    const Plan plan = make_plan(scene, job);
    const std::vector<Pilot> pilots = {run_pilot(scene, job, plan, LightingState::kAlbedo, cancel)};
    std::vector<ProbeResult> results;
    for (size_t i = 0; i < 3; ++i) {
        results.push_back(bake_probe(scene, job, pilots[0], {.probe = i}, cancel));
    }
    const BakeRecord record{.scene = scene,
                            .job = job,
                            .plan = plan,
                            .pilots = pilots,
                            .results = results,
                            .wall_seconds = 1.5,
                            .peak_memory_bytes = 1000};
    const MeasuredError pooled = pooled_error(record, LightingState::kAlbedo);
    uint64_t samples = 0;
    double mean = 0.0;
    for (const ProbeResult& result : results) {
        samples += result.certificate.pixels;
        mean += result.certificate.error.mse.value / 3.0;
    }
    EXPECT_EQ(pooled.mse.samples, samples);
    EXPECT_NEAR(pooled.mse.value, mean, 1e-12);

    const Json report = write_report(record);
    const Json& state = report["states"][0];
    EXPECT_EQ(state["error"]["evidence"], "job");
    EXPECT_EQ(report["effective_request"], write_job(job));
    EXPECT_EQ(report["scene"]["voxels"], scene.tree.voxel_count());
    EXPECT_EQ(report["deterministic"], true);
    EXPECT_GE(state["curve"].size(), 5u);
    uint64_t rays = 0;
    uint64_t bytes = 0;
    int judged = 0;
    for (const ProbeResult& result : results) {
        const Json row = write_probe_row(record, pilots[0], result, pooled);
        EXPECT_EQ(row["faces"].size(), 6u);
        uint64_t of_faces = 0;
        for (const Json& face : row["faces"]) of_faces += face["rays"].get<uint64_t>();
        EXPECT_EQ(of_faces, row["cost"]["render"]["rays"]);
        rays += of_faces;
        bytes += row["files"][0]["bytes"].get<uint64_t>();
        judged += row["result"] == "target_met" ? 1 : 0;
    }
    EXPECT_EQ(report["totals"]["cost"]["render"]["rays"], rays);
    EXPECT_EQ(report["totals"]["bytes"], bytes);
    EXPECT_EQ(state["results"].value("target_met", 0), judged);
    const Json& cost = report["totals"]["cost"];
    EXPECT_NEAR(cost["audit_steps_over_render"].get<double>(),
                cost["audit"]["steps"].get<double>() / cost["render"]["steps"].get<double>(),
                1e-12);
    // Nothing in it that is not JSON: no NaN, no infinity.
    EXPECT_EQ(Json::parse(dump_json(report)), report);
}

}  // namespace
}  // namespace probebake
