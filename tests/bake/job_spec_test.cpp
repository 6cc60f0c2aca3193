#include "bake/job_spec.h"

#include <gtest/gtest.h>

#include "bake/bake_fixture.h"

namespace probebake {
namespace {

/// "400 or 422, pointer: detail" of the first issue; "none" where the request is accepted.
std::string problem_of(const Json& request) {
    try {
        read_job(request);
    } catch (const SpecError& error) {
        const SpecIssue& issue = error.issues().front();
        return (error.kind() == SpecError::Kind::kMalformed ? "400 " : "422 ") + issue.pointer +
               ": " + issue.detail;
    }
    return "none";
}

/// The small request with the value at a JSON pointer replaced.
Json with(const std::string& pointer, const Json& value) {
    Json request = test::small_request();
    request[Json::json_pointer(pointer)] = value;
    return request;
}

TEST(JobSpec, FillsInDefaults) {
    const JobSpec job = read_job(
        {{"scene", "demo"}, {"probes", {{"list", {{{"id", "a"}, {"position_m", {1, 2, 3}}}}}}}});
    EXPECT_EQ(job.scene, "demo");
    EXPECT_EQ(job.states, std::vector{LightingState::kAlbedo});
    ASSERT_EQ(job.probes.size(), 1u);
    EXPECT_EQ(job.probes[0].face_size_px, 64);
    EXPECT_EQ(job.probes[0].near_m, 0.0);
    EXPECT_FALSE(job.probes[0].far_m);
    EXPECT_EQ(job.quality.targets.front().metric, QualityTarget::Metric::kPsnrDb);
    EXPECT_EQ(job.quality.targets.front().value, 40.0);
    EXPECT_FALSE(job.quality.renderer);
    EXPECT_TRUE(job.quality.evidence.audit);
    EXPECT_EQ(job.seed, 1u);
}

TEST(JobSpec, TheEffectiveRequestReadsBackAsTheSameJob) {
    Json request = test::small_request(3, {{"rmse", 0.02}});
    request["lighting_states"] = {"albedo", "emission"};
    request["products"] = {"cube", "aux"};
    request["near_m"] = 0.5;
    request["far_m"] = 300.0;
    request["quality"]["against"] = "reference";
    request["quality"]["renderer"] = "error_aware";
    request["quality"]["settings"] = {{"threshold", 0.1}, {"leaf_grid", 8}, {"spread", 0.02}};
    request["quality"]["exposure"] = 0.8;
    request["quality"]["weighting"] = "solid_angle";
    request["quality"]["evidence"] = {{"pixels_per_probe", 100}, {"confidence", 0.9}};
    request["budget"] = {{"rays", 1'000'000}, {"seconds", 12.5}, {"memory_bytes", 1'000'000'000}};
    request["on_budget_exhausted"] = "fail";
    request["priority"] = -7;
    request["probes"]["grids"] = {{{"id", "g"},
                                   {"origin_m", {0, 1, 2}},
                                   {"spacing_m", {2, 3, 4}},
                                   {"counts", {2, 1, 2}},
                                   {"face_size_px", 32}}};
    const Json effective = write_job(read_job(request));
    EXPECT_EQ(effective["probes"]["list"].size(), 3u);
    EXPECT_EQ(effective["probes"]["list"][0]["near_m"], 0.5);
    EXPECT_EQ(effective["probes"]["grids"].size(), 1u);
    EXPECT_EQ(effective["probes"]["grids"][0]["face_size_px"], 32);
    EXPECT_EQ(write_job(read_job(effective)), effective);
    const std::vector<ProbeSpec> probes = read_job(effective).probes;
    ASSERT_EQ(probes.size(), 7u);
    EXPECT_EQ(probes[6].id, "g-1-0-1");
    EXPECT_EQ(probes[6].position_m, Vec3(2.0, 1.0, 6.0));
    EXPECT_EQ(probes[6].face_size_px, 32);
}

TEST(JobSpec, ReadsEachTarget) {
    const auto target = [](const Json& targets) {
        return read_job(test::small_request(1, targets)).quality.targets.front();
    };
    EXPECT_EQ(target({{"ssim", 0.9}}).metric, QualityTarget::Metric::kSsim);
    EXPECT_EQ(target({{"rays", 100'000}}).value, 100'000.0);
    EXPECT_EQ(target({{"rmse", 0.01}}).value, 0.01);
    EXPECT_EQ(target({{"rel_mse", 0.02}}).metric, QualityTarget::Metric::kRelMse);
    EXPECT_EQ(target({{"rel_mse", 0.02}}).value, 0.02);
}

TEST(JobSpec, ReadsSeveralTargetsAndWhichOfThemCount) {
    Json request = test::small_request(1, {{"psnr_db", 30.0}, {"ssim", 0.9}});
    EXPECT_EQ(read_job(request).quality.targets.size(), 2u);
    EXPECT_EQ(read_job(request).quality.require, Require::kAll);
    request["quality"]["require"] = "any";
    const JobSpec job = read_job(request);
    EXPECT_EQ(job.quality.require, Require::kAny);
    EXPECT_EQ(write_job(read_job(write_job(job))), write_job(job));
    request["quality"]["require"] = "most";
    EXPECT_EQ(problem_of(request).substr(0, 21), "400 /quality/require:");
}

TEST(JobSpec, EvidenceMayBeNone) {
    Json request = test::small_request();
    request["quality"]["evidence"] = "none";
    EXPECT_FALSE(read_job(request).quality.evidence.audit);
    EXPECT_EQ(write_job(read_job(request))["quality"]["evidence"]["audit"], false);
    request["quality"]["evidence"] = "some";
    EXPECT_EQ(problem_of(request).substr(0, 22), "400 /quality/evidence:");
    request["quality"]["evidence"] = 3;
    EXPECT_EQ(problem_of(request).substr(0, 22), "400 /quality/evidence:");
}

TEST(JobSpec, SaysWhereAndWhatWasExpected) {
    EXPECT_EQ(problem_of(test::small_request()), "none");
    const std::pair<Json, std::string> cases[] = {
        {Json::array(), "400 : expected an object"},
        {{{"scene", "x"}}, "400 /probes: is required"},
        {with("/scene", "../etc"), "400 /scene: expected a name"},
        {with("/scene", 5), "400 /scene: expected a name"},
        {with("/colour", 1), "400 /colour: is unknown"},
        {with("/quality/targets/psnr", 1), "400 /quality/targets/psnr: is unknown"},
        {with("/quality/targets/psnr_db", -1), "422 /quality/targets/psnr_db: is -1"},
        {with("/quality/targets/psnr_db", "40"), "400 /quality/targets/psnr_db: expected a number"},
        {with("/quality/targets/rays", 100'000), "422 /quality/targets/rays: a number of rays is"},
        {with("/quality/renderer", "best"), "400 /quality/renderer: expected one of"},
        {with("/quality/settings", {{"threshold", 0.1}}),
         "422 /quality/settings: settings of your own need a renderer"},
        {with("/face_size_px", 0), "422 /face_size_px: is 0, expected an integer from 1 to 4096"},
        {with("/face_size_px", 64.5), "400 /face_size_px: expected an integer"},
        {with("/face_size_px", 1e300), "400 /face_size_px: expected an integer"},
        {with("/seed", -1), "422 /seed: is -1"},
        {with("/far_m", 0), "422 /far_m: is 0"},
        {with("/near_m", -0.1), "422 /near_m: is -0.1"},
        {with("/lighting_states", Json::array()),
         "422 /lighting_states: expected at least one state"},
        {with("/lighting_states", {"albedo", "albedo"}), "422 /lighting_states/1: the state"},
        {with("/lighting_states", {"noon"}), "422 /lighting_states/0: expected \"albedo\""},
        {with("/products", Json::array()), "422 /products: expected at least one of \"cube\""},
        {with("/probes/list/1/id", "p0"),
         "422 /probes/list/1/id: the probe id \"p0\" is used twice"},
        {with("/probes/list/0/position_m", {1, 2}),
         "400 /probes/list/0/position_m: expected an array of three numbers"},
        {with("/probes/list/0/position_m", {1, 2, nullptr}),
         "400 /probes/list/0/position_m/2: expected a number"},
        {with("/probes/list/0/position_m", {1, 2, 2e6}),
         "422 /probes/list/0/position_m/2: is 2e+06"},
        {with("/budget/rays", 100), "422 /budget/rays: expected at least one ray per pixel"},
        {with("/budget/seconds", 0), "422 /budget/seconds: is 0"},
        {with("/budget/memory_bytes", -1), "422 /budget/memory_bytes: is -1"},
        {with("/on_budget_exhausted", "stop"),
         "400 /on_budget_exhausted: expected one of \"return_best\", \"fail\""},
        {with("/priority", 101), "422 /priority: is 101"},
        {with("/quality/evidence/confidence", 1), "422 /quality/evidence/confidence: is 1"},
        {with("/probes", {{"list", Json::array()}}), "422 /probes: expected at least one probe"},
    };
    for (const auto& [request, expected] : cases) {
        EXPECT_EQ(problem_of(request).substr(0, expected.size()), expected) << request.dump();
    }
}

TEST(JobSpec, AShortRequestCannotAskForTheMoon) {
    const auto grid = [](const Json& counts, double spacing_m = 1.0) {
        return with("/probes/grids", {{{"id", "g"},
                                       {"origin_m", {0, 0, 0}},
                                       {"spacing_m", {spacing_m, spacing_m, spacing_m}},
                                       {"counts", counts}}});
    };
    EXPECT_EQ(problem_of(grid({40, 40, 40})), "none");
    for (const Json& counts : {Json{1000, 1000, 1000}, Json{100000, 100000, 1}, Json{65536, 1, 1},
                               Json{1e9, 1e9, 1e9}}) {
        EXPECT_EQ(problem_of(grid(counts)),
                  "422 /probes/grids/0/counts: the job would have more than 65536 probes");
    }
    EXPECT_EQ(problem_of(grid({0, 1, 1})).substr(0, 33), "422 /probes/grids/0/counts/0: exp");
    EXPECT_EQ(problem_of(grid({1.5, 1, 1})).substr(0, 33), "422 /probes/grids/0/counts/0: exp");
    EXPECT_EQ(problem_of(grid({2, 1, 1}, 1e6 + 1)).substr(0, 31),
              "422 /probes/grids/0/spacing_m/0");
    // Few probes, each within its limit, may still be too many texels.
    Json big = grid({30, 10, 10});
    big["face_size_px"] = 4096;
    EXPECT_EQ(problem_of(big).substr(0, 24), "422 /probes: the job has");
}

TEST(JobSpec, TargetsThatOneProbeCannotHave) {
    EXPECT_EQ(problem_of(test::small_request(1, {{"rays", 100}})).substr(0, 60),
              "422 /quality/targets/rays: expected at least one ray per pix");
    Json tiny = test::small_request(1, {{"ssim", 0.9}});
    tiny["face_size_px"] = 8;
    EXPECT_EQ(problem_of(tiny).substr(0, 40), "422 /quality/targets/ssim: SSIM is not d");
}

TEST(JobSpec, CountsTexelsAndPixels) {
    JobSpec job = test::small_job(3);
    EXPECT_EQ(texel_count(job), 3u * 6 * 16 * 16);
    EXPECT_EQ(pixel_count(job), 3u * (6 * 14 * 14 + 12 * 14 + 8));
    job.states.push_back(LightingState::kEmission);
    EXPECT_EQ(texel_count(job), 6u * 6 * 16 * 16);
}

TEST(JobSpec, ValidityIsAskedOrNot) {
    EXPECT_FALSE(test::small_job().validity);
    EXPECT_FALSE(write_job(test::small_job()).contains("validity"));
    const JobSpec plain = read_job(with("/validity", Json::object()));
    ASSERT_TRUE(plain.validity);
    EXPECT_EQ(plain.validity->rules.max_backface, 0.25);
    EXPECT_EQ(plain.validity->rules.max_closed_in, 1.0);
    EXPECT_FALSE(plain.validity->relocate);
    EXPECT_EQ(plain.validity->max_offset_m, 0.0);
    const Json full = {
        {"max_backface", 0.4}, {"max_closed_in", 0.7}, {"relocate", true}, {"max_offset_m", 1.5}};
    const JobSpec job = read_job(with("/validity", full));
    EXPECT_EQ(write_job(job)["validity"], full);
    EXPECT_EQ(problem_of(with("/validity", true)).substr(0, 14), "400 /validity:");
    EXPECT_EQ(problem_of(with("/validity/max_backface", 1.5)).substr(0, 27),
              "422 /validity/max_backface:");
    EXPECT_EQ(problem_of(with("/validity/max_offset_m", 1.0)),
              "422 /validity/max_offset_m: moves nothing: expected \"relocate\": true with it");
    EXPECT_EQ(problem_of(with("/validity/relocate", "yes")).substr(0, 23),
              "400 /validity/relocate:");
    EXPECT_EQ(problem_of(with("/validity/offset", 1)).substr(0, 21), "400 /validity/offset:");
}

}  // namespace
}  // namespace probebake
