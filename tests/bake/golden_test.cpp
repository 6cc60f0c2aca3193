// Scenes without media run the code that they ran before there were any: rays, steps and pixels of
// small bakes, recorded before media came into the bake (2026-11-22). A change of the renderers
// changes them on purpose: take the new lines from the failure's text.
#include <gtest/gtest.h>

#include <bit>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "image/exr.h"
#include "math/random.h"

namespace probebake {
namespace {

/// Of all values of a cubemap, bit by bit.
uint64_t key_of(const Cubemap& cube) {
    uint64_t key = 0;
    for (const Rgb& pixel : cube.image().pixels()) {
        for (int c = 0; c < 3; ++c) key = random_key({key, std::bit_cast<uint32_t>(pixel[c])});
    }
    return key;
}

std::string line_of(const Scene& scene, const Json& request) {
    const CancelToken cancel;
    const JobSpec job = read_job(request);
    const ReadyState state = light_state(scene, job, 0, cancel);
    const Pilot pilot = run_pilot(scene, job, make_plan(scene, job), state, cancel);
    const ProbeResult result = bake_probe(scene, job, pilot, {.probe = 1}, cancel);
    const CostStats render = result.render_cost();
    std::string line;
    for (const uint64_t count :
         {render.rays, render.discarded_rays, render.missed_rays, render.steps, render.box_tests,
          result.earlier_renders.steps + result.decision_cost.steps, result.certificate.cost.steps,
          pilot.search_cost.steps + pilot.curve_cost.steps,
          key_of(decode_cubemap(result.files[0].bytes, "").cubemap)}) {
        line += (line.empty() ? "" : " ") + std::to_string(count);
    }
    return line;
}

struct GoldenCase {
    const char* name;
    const char* change;  // of the request, as a JSON merge patch
    const char* line;
};

class GoldenTest : public testing::TestWithParam<GoldenCase> {};

TEST_P(GoldenTest, CountsAndPixelsAreThoseOfBefore) {
    Json request = test::small_request();
    request.merge_patch(Json::parse(GetParam().change));
    EXPECT_EQ(line_of(test::small_scene(), request), GetParam().line);
}

constexpr const char* kLit = R"({"lighting_states": [{"id": "day",
    "sun": {"direction": [1, 2, 0.5], "irradiance_w_m2": [3, 2, 1]},
    "sky": {"type": "constant", "radiance_w_m2_sr": [0.2, 0.3, 0.5]}}]})";

INSTANTIATE_TEST_SUITE_P(
    WithoutMedia, GoldenTest,
    testing::Values(
        GoldenCase{"Hybrid", "{}",
                   "125364 0 39123 601098 714900 11389 30346 458189 10404513416922823203"},
        GoldenCase{"ErrorAware", R"({"quality": {"renderer": "error_aware"}})",
                   "65984 21544 19210 1232744 0 0 26075 2503150 16718092468793836815"},
        GoldenCase{"Adaptive", R"({"quality": {"renderer": "adaptive"}})",
                   "20162 1254 7736 286700 0 0 10213 564146 9200027269890008547"},
        GoldenCase{"Reference", R"({"quality": {"renderer": "reference"}})",
                   "346112 0 145765 4547031 0 0 127745 3558745 4519257595027265180"},
        GoldenCase{"Lod", R"({"quality": {"renderer": "lod"}})",
                   "1352 0 314 15187 0 0 3054 278217 13604035147412957427"},
        GoldenCase{"AgainstReference", R"({"quality": {"against": "reference"}})",
                   "21632 6760 9201 367174 0 0 19438 496283 6321436236847626386"},
        GoldenCase{"Emission", R"({"lighting_states": ["emission"]})",
                   "1352 0 314 15187 0 0 3634 59893 1540102400144685580"},
        GoldenCase{"Lit", kLit,
                   "154020 0 45407 756720 893184 26627 29027 467318 8359496460314082578"},
        GoldenCase{"Ssim", R"({"quality": {"targets": {"psnr_db": null, "ssim": 0.95}}})",
                   "49220 0 15149 275767 392026 0 205020 716730 1704202772101279550"},
        GoldenCase{"Rays", R"({"quality": {"targets": {"psnr_db": null, "rays": 9000}}})",
                   "8372 0 2737 56141 92707 0 5184 147584 8557715311679284690"},
        GoldenCase{"Irradiance",
                   R"({"quality": {"targets": {"psnr_db": null, "irradiance_rel": 0.1}}})",
                   "12168 0 5128 159851 0 27177 31707 938400 6478993847539340985"}),
    [](const auto& test_case) { return std::string(test_case.param.name); });

}  // namespace
}  // namespace probebake
