// What audits cost in jobs whose probes learn from each other, and how probes are judged whose
// audit was spared.
#include <gtest/gtest.h>

#include <algorithm>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "bake/learn.h"
#include "bake/report.h"

namespace probebake {
namespace {

constexpr int kProbes = 100;

class AuditShareTest : public testing::Test {
  protected:
    JobSpec job_of(int face_size_px, const Json& targets, const Json& renderer = {}) const {
        Json request = test::small_request(1, targets);
        if (!renderer.is_null()) request["quality"]["renderer"] = renderer;
        request["face_size_px"] = face_size_px;
        request["probes"]["list"].clear();
        for (int i = 0; i < kProbes; ++i) {
            const int level = i / 5 % 4;
            const int row = i / 20;
            const Vec3 offset(0.7 * (i % 5), 0.6 * level, -0.8 * row);
            const Vec3 p = scene_.to_metres(test::kSmallWorldProbe + offset);
            request["probes"]["list"].push_back(
                {{"id", "p" + std::to_string(i)}, {"position_m", {p.x, p.y, p.z}}});
        }
        return read_job(request);
    }

    struct Baked {
        JobSpec job;
        Plan plan;
        std::vector<Pilot> pilots;
        std::vector<ProbeResult> results;
    };

    Baked bake(const JobSpec& job) const { return bake(scene_, job, LightingState::kAlbedo); }
    static Baked bake(const Scene& scene, const JobSpec& job, const LightingState& state) {
        const CancelToken cancel;
        Baked baked{.job = job, .plan = make_plan(scene, job), .pilots = {}, .results = {}};
        baked.pilots.push_back(run_pilot(scene, job, baked.plan, state, cancel));
        Pilot& pilot = baked.pilots.front();
        const size_t first = probes_to_learn_from(job);
        for (size_t i = 0; i < job.probes.size(); ++i) {
            if (i == first) learn(pilot, job.quality, baked.results);
            baked.results.push_back(
                bake_probe(scene, job, pilot, {.probe = i, .teaches = i < first}, cancel));
        }
        return baked;
    }

    static double share_of_audits(const Baked& baked) {
        CostStats render;
        CostStats audit;
        for (const ProbeResult& result : baked.results) {
            render += result.render_cost();
            audit += result.decision_cost;
            audit += result.certificate.cost;
        }
        return static_cast<double>(audit.steps) / static_cast<double>(render.steps);
    }

    static void expect_small_share(const Baked& baked) {
        const int face_size_px = baked.job.probes.front().face_size_px;
        const std::string what =
            std::to_string(face_size_px) + "² " + write_job(baked.job)["quality"].dump();
        const auto met = std::count_if(baked.results.begin(), baked.results.end(),
                                       [](const ProbeResult& r) { return r.target_met; });
        const double share = share_of_audits(baked);
        std::printf("%s: %.3f, %d of %d met\n", what.c_str(), share, static_cast<int>(met),
                    kProbes);
        EXPECT_LT(share, 0.15) << what;
        EXPECT_GT(share, 0.01) << what;
    }

    const Scene scene_ = test::small_scene();
};

TEST_F(AuditShareTest, IsBelowFifteenHundredthsWhateverIsAskedFor) {
    struct Kind {
        int face_size_px = 0;
        Json targets;
        Json renderer;  // null: what the plan takes
    };
    // 45 dB are beyond most of the probes.
    const std::vector<Kind> kinds = {{16, {{"psnr_db", 30}}},
                                     {16, {{"psnr_db", 45}}},
                                     {16, {{"rel_mse", 0.02}}},
                                     {16, {{"psnr_db", 32}, {"ssim", 0.9}}},
                                     {16, {{"ssim", 0.9}}},
                                     {16, {{"ssim", 0.9}}, "adaptive"},
                                     {16, {{"irradiance_rel", 0.03}}},
                                     {8, {{"psnr_db", 32}}},
                                     {8, {{"rel_mse", 0.02}}},
                                     {8, {{"irradiance_rel", 0.03}}},
                                     {4, {{"psnr_db", 45}}},
                                     {4, {{"psnr_db", 30}, {"irradiance_rel", 0.03}}},
                                     {4, {{"irradiance_rel", 0.03}}},
                                     {4, {{"psnr_db", 20}}, "lod"},
                                     {2, {{"psnr_db", 32}}},
                                     {2, {{"rel_mse", 0.02}}},
                                     {2, {{"irradiance_rel", 0.03}}},
                                     {2, {{"psnr_db", 30}}, "adaptive"},
                                     {1, {{"psnr_db", 25}}},
                                     {1, {{"psnr_db", 45}}},
                                     {1, {{"irradiance_rel", 0.1}}},
                                     {1, {{"psnr_db", 30}}, "reference"}};
    for (const auto& [face_size_px, targets, renderer] : kinds) {
        expect_small_share(bake(job_of(face_size_px, targets, renderer)));
    }
}

// Few steps are taken there, and rays to lamps are long.
TEST_F(AuditShareTest, IsBelowFifteenHundredthsAmongLampsInTheDark) {
    VoxelCloud cloud = test::small_world_voxels();
    for (int i = 0; i < 16; ++i) {
        const IVec3 beside_a_pillar(16 * (i % 4) + 7, 25, 16 * (i / 4) + 9);
        cloud.voxels.push_back(
            make_voxel(beside_a_pillar, pack_rgb(Rgb(0.5f)), pack_rgb(Rgb(5'000.0f))));
    }
    Scene scene = test::small_scene();
    scene.tree = VoxelTree::build(cloud);
    for (const int face_size_px : {16, 8, 4, 2}) {
        for (const Json& targets : {Json{{"psnr_db", 35}}, Json{{"irradiance_rel", 0.05}}}) {
            JobSpec job = job_of(face_size_px, targets);
            job.quality.exposure = 5'000.0;
            expect_small_share(bake(scene, job, LightingState::kEmission));
        }
    }
}

TEST_F(AuditShareTest, ProbesWhoseAuditIsSparedAreJudgedByTheOthers) {
    const Baked baked = bake(job_of(4, {{"psnr_db", 25}}));
    const BakeRecord record{.scene = scene_,
                            .job = baked.job,
                            .plan = baked.plan,
                            .pilots = baked.pilots,
                            .results = baked.results};
    int spared = 0;
    for (const ProbeResult& result : baked.results) {
        EXPECT_TRUE(result.audited());
        if (result.certificate.pixels > 0) continue;
        ++spared;
        EXPECT_NE(result.evidence, EvidenceOf::kProbe);
        const Json row = write_probe_row(record, baked.pilots[0], result, {});
        EXPECT_NE(row["result"], "not_audited");
        EXPECT_GT(row["error"]["psnr_db"].get<double>(), 20.0);
        EXPECT_FALSE(row["error"].contains("own_audit"));
        EXPECT_TRUE(error_figures(baked.job.quality, result).has_value());
    }
    EXPECT_GT(spared, kProbes / 4);
    EXPECT_LT(spared, kProbes) << "else nothing is known of any";
    const Json state = write_report(record)["states"][0];
    EXPECT_GT(state["error"]["psnr_db"].get<double>(), 20.0);
}

// No ray takes a step: shares of nothing are no numbers.
TEST_F(AuditShareTest, ProbesThatSeeNothingAreAudited) {
    JobSpec job = job_of(4, {{"psnr_db", 30}});
    for (ProbeSpec& probe : job.probes) {
        probe.position_m += Vec3(1e4);
        probe.far_m = 1.0;
    }
    for (const ProbeResult& result : bake(job).results) {
        EXPECT_EQ(result.render_cost().steps, 0u);
        EXPECT_GT(result.certificate.pixels, 0u);
        EXPECT_TRUE(result.certificate.error.mse.nothing_found());
    }
}

}  // namespace
}  // namespace probebake
