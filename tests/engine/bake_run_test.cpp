#include "engine/bake_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include "bake/bake_fixture.h"

namespace probebake {
namespace {

class BakeRunTest : public testing::Test {
  protected:
    struct Outcome {
        std::map<std::string, std::string> sha256;  // by probe/state/file
        std::vector<BakeProgress> progress;
        std::vector<Json> rows;
        Json report;
    };

    Outcome bake(const JobSpec& job, int threads) {
        RenderPool pool(threads);
        Outcome out;
        BakeParams params = this->params(job, pool);
        params.sink = [&](const ProbeSpec& probe, const ProbeResult& result) {
            for (const ProductFile& file : result.files) {
                EXPECT_EQ(file.bytes.size(), file.size_bytes);
                out.sha256[probe.id + "/" + std::string(name_of(result.state)) + "/" + file.name] =
                    file.sha256;
            }
        };
        params.grid_sink = [&](const GridResult& result) {
            for (const ProductFile& file : result.files) {
                EXPECT_EQ(file.bytes.size(), file.size_bytes);
                out.sha256[result.grid + "/" + result.state + "/" + file.name] = file.sha256;
            }
        };
        params.on_progress = [&](const BakeProgress& p) { out.progress.push_back(p); };
        params.row_sink = [&](const Json& row) { out.rows.push_back(row); };
        out.report = run_bake(params);
        return out;
    }
    BakeParams params(const JobSpec& job, RenderPool& pool) {
        return {.job = job,
                .scene = [&](const CancelToken&) { return scene_; },
                .pool = pool,
                .cancel = cancel_};
    }

    std::shared_ptr<const Scene> scene_ = std::make_shared<const Scene>(test::small_scene());
    CancelToken cancel_;
};

TEST_F(BakeRunTest, BakesEveryProbeInEveryStateWithTheSameBytesForAnyThreadCount) {
    Json request = test::small_request(5, {{"psnr_db", 28.0}});
    request["lighting_states"] = {"albedo", "emission"};
    request["products"] = {"cube", "aux"};
    const JobSpec job = read_job(request);
    const Outcome one = bake(job, 1);
    EXPECT_EQ(one.sha256.size(), 5u * 2 * 2);
    ASSERT_EQ(one.rows.size(), 10u);
    EXPECT_EQ(one.rows[3]["probe"], "p1");
    EXPECT_EQ(one.rows[3]["state"], "emission");
    EXPECT_EQ(one.report["totals"]["cubemaps"], 10u);
    for (const int threads : {2, 7}) EXPECT_EQ(bake(job, threads).sha256, one.sha256) << threads;
}

TEST_F(BakeRunTest, AGridHasItsAtlasesOncePerState) {
    Json request = test::small_request(1, {{"rays", 40'000}});
    const Json origin = request["probes"]["list"][0]["position_m"];
    request["probes"] = {
        {"grids",
         {{{"id", "near"},
           {"origin_m", origin},
           {"spacing_m", {0.5, 0.25, 0.5}},
           {"counts", {2, 2, 1}}},
          {{"id", "far"}, {"origin_m", origin}, {"spacing_m", {1, 1, 1}}, {"counts", {1, 1, 2}}}}}};
    request["lighting_states"] = {"albedo", "emission"};
    request["products"] = {"sh", "ddgi"};
    const JobSpec job = read_job(request);
    const Outcome one = bake(job, 1);
    EXPECT_EQ(one.sha256.size(), 6u * 2 + 2 * 2 * 2);
    ASSERT_EQ(one.rows.size(), 6u * 2 + 2 * 2);
    const Json& row = one.rows[13];
    EXPECT_EQ(row["grid"], "near");
    EXPECT_EQ(row["state"], "emission");
    ASSERT_EQ(row["files"].size(), 2u);
    EXPECT_EQ(row["files"][1]["sha256"], one.sha256.at("near/emission/ddgi-distance.exr"));
    // Distances do not depend on what is seen; a black state's irradiance does.
    EXPECT_NE(one.sha256.at("near/albedo/ddgi-irradiance.exr"),
              one.sha256.at("near/emission/ddgi-irradiance.exr"));
    uint64_t bytes = 0;
    for (const Json& any : one.rows) {
        for (const Json& file : any["files"]) bytes += file["bytes"].get<uint64_t>();
    }
    EXPECT_EQ(one.report["totals"]["bytes"], bytes);
    EXPECT_LT(bytes, one.report["plan"]["output_bytes_at_most"].get<uint64_t>());
    for (const int threads : {2, 7}) EXPECT_EQ(bake(job, threads).sha256, one.sha256) << threads;
}

Json lit_request(int probes) {
    Json request = test::small_request(probes, {{"psnr_db", 28.0}});
    request["lighting_states"] = {
        "albedo",
        {{"id", "day"},
         {"sun", {{"direction", {1, 3, 2}}, {"irradiance_w_m2", {900, 850, 800}}}},
         {"sky", {{"type", "constant"}, {"radiance_w_m2_sr", {10, 20, 30}}, {"rays", 8}}}}};
    return request;
}

TEST_F(BakeRunTest, ALitStateGivesTheSameBytesForAnyThreadCountAndAnyCompany) {
    const JobSpec job = read_job(lit_request(3));
    const Outcome one = bake(job, 1);
    EXPECT_EQ(one.sha256.size(), 3u * 2);
    for (const int threads : {2, 7}) EXPECT_EQ(bake(job, threads).sha256, one.sha256) << threads;
    // Another state beside it changes nothing.
    JobSpec alone = job;
    alone.states.erase(alone.states.begin());
    for (const auto& [name, sha256] : bake(alone, 2).sha256) EXPECT_EQ(one.sha256.at(name), sha256);
    // The report says what the light cost; the plan expected its memory.
    const Json& states = one.report["states"];
    EXPECT_FALSE(states[0].contains("lighting"));
    EXPECT_GT(states[1]["lighting"]["sky_rays"], 1000);
    EXPECT_GT(states[1]["lighting"]["bytes"], 1000);
    EXPECT_GT(one.report["plan"]["memory"]["light_bytes"], 1000);
    EXPECT_TRUE(std::any_of(one.progress.begin(), one.progress.end(), [](const auto& progress) {
        return progress.phase == BakePhase::kLighting;
    }));
}

TEST_F(BakeRunTest, CancellingStopsTheLighting) {
    Json request = lit_request(1);
    request["lighting_states"][1]["sky"]["rays"] = 4096;
    request["lighting_states"][1]["sky"]["gather_m"] = 0.01;
    const JobSpec job = read_job(request);
    RenderPool pool(2);
    BakeParams params = this->params(job, pool);
    std::chrono::steady_clock::time_point asked;
    std::thread canceller;
    params.on_progress = [&](const BakeProgress& progress) {
        if (progress.phase != BakePhase::kLighting) return;
        canceller = std::thread([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            asked = std::chrono::steady_clock::now();
            cancel_.cancel();
        });
    };
    EXPECT_THROW(run_bake(params), Cancelled);
    const auto stopped = std::chrono::steady_clock::now();
    canceller.join();
    EXPECT_LT(std::chrono::duration<double>(stopped - asked).count(), 1.0);
}

TEST_F(BakeRunTest, ReportsProgressThroughItsPhases) {
    const Outcome out = bake(test::small_job(4), 2);
    std::set<BakePhase> phases;
    uint64_t done = 0;
    for (const BakeProgress& progress : out.progress) {
        phases.insert(progress.phase);
        EXPECT_GE(progress.units_done, done);
        done = progress.units_done;
        EXPECT_EQ(progress.units, 4u);
    }
    EXPECT_EQ(phases.size(), 4u);
    EXPECT_EQ(done, 4u);
    EXPECT_NEAR(*out.progress.back().seconds_left, 0.0, 1e-9);
}

TEST_F(BakeRunTest, CancellingStopsBeforeTheNextUnit) {
    const JobSpec job = test::small_job(50);
    RenderPool pool(2);
    BakeParams params = this->params(job, pool);
    int published = 0;
    params.sink = [&](const ProbeSpec&, const ProbeResult&) {
        if (++published == 2) cancel_.cancel();
    };
    EXPECT_THROW(run_bake(params), Cancelled);
    EXPECT_LE(published, 4);
}

TEST_F(BakeRunTest, AUnitIsMendedFromWhatTheJobHad) {
    // So many that the last ones learn from the first; one of these was given up.
    const JobSpec job = test::small_job(32, {{"psnr_db", 28.0}});
    RenderPool pool(2);
    std::map<size_t, std::string> sha256;
    BakeParams params = this->params(job, pool);
    params.history.given_up = {{1, "brings the process down"}};
    params.sink = [&](const ProbeSpec&, const ProbeResult& result) {
        const auto [at, is_new] = sha256.emplace(result.probe, result.files[0].sha256);
        EXPECT_EQ(at->second, result.files[0].sha256);
    };
    EXPECT_THROW(run_bake(params), UnitsFailed);
    EXPECT_EQ(sha256.size(), 31U);
    params.history.only = {31};
    EXPECT_EQ(run_bake(params), nullptr);
    EXPECT_FALSE(sha256.contains(1));
    params.history.only = {1};
    EXPECT_THROW(run_bake(params), UnitsFailed) << "what is given up cannot be mended";
}

TEST_F(BakeRunTest, SuspectsAreBakedLastAndAlone) {
    const JobSpec job = read_job(test::small_request(12, {{"psnr_db", 28.0}}));
    RenderPool pool(4);
    BakeParams params = this->params(job, pool);
    params.history.suspects = {3, 4, 9};
    std::mutex mutex;
    std::set<size_t> under_way;
    std::set<size_t> done;
    params.begin = [&](size_t unit) {
        const std::lock_guard lock(mutex);
        const bool is_suspect = params.history.suspects.contains(unit);
        EXPECT_TRUE(!is_suspect || (under_way.empty() && done.size() >= 9)) << unit;
        under_way.insert(unit);
    };
    params.sink = [&](const ProbeSpec&, const ProbeResult& result) {
        const std::lock_guard lock(mutex);
        under_way.erase(unit_of(job, result));
        done.insert(unit_of(job, result));
    };
    run_bake(params);
    EXPECT_EQ(done.size(), 12U);
}

TEST_F(BakeRunTest, AFailingSinkFailsTheBake) {
    const JobSpec job = test::small_job(4);
    RenderPool pool(2);
    BakeParams params = this->params(job, pool);
    params.sink = [](const ProbeSpec&, const ProbeResult&) {
        throw std::runtime_error("the disk is full");
    };
    EXPECT_THROW(run_bake(params), std::runtime_error);
}

TEST_F(BakeRunTest, ABudgetOfSecondsIsKept) {
    Json request = test::small_request(40, {{"psnr_db", 60.0}});
    request["face_size_px"] = 48;
    request["budget"]["seconds"] = 0.5;
    const Outcome out = bake(read_job(request), 2);
    EXPECT_EQ(out.report["deterministic"], false);
    // Of a busy machine, too: what the job would take without is minutes then.
    EXPECT_LT(out.report["totals"]["wall_seconds"].get<double>(), 60.0);
    EXPECT_EQ(out.sha256.size(), 40u);
    int exhausted = 0;
    for (const Json& row : out.rows) exhausted += row["result"] == "budget_exhausted" ? 1 : 0;
    EXPECT_GT(exhausted, 20);
}

}  // namespace
}  // namespace probebake
