#include "bake/forecast.h"

#include <gtest/gtest.h>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"

namespace probebake {
namespace {

// Bytes and cost follow the number of pixels; seconds of a machine are not tested here.
TEST(Forecast, GrowsWithTheJob) {
    const Scene scene = test::small_scene();
    const CancelToken cancel;
    const auto forecast = [&](const JobSpec& job) {
        return make_forecast(scene, job, make_plan(scene, job), 2, cancel);
    };
    JobSpec many = test::small_job(4);
    const Forecast small = forecast(many);
    for (int i = 4; i < 40; ++i) many.probes.push_back(many.probes[static_cast<size_t>(i % 4)]);
    const Forecast large = forecast(many);
    EXPECT_GT(small.seconds, 0.0);
    EXPECT_GT(large.seconds, small.seconds);
    EXPECT_NEAR(static_cast<double>(large.output_bytes),
                10.0 * static_cast<double>(small.output_bytes),
                0.2 * static_cast<double>(large.output_bytes));
    EXPECT_GE(large.memory_bytes, small.memory_bytes);
    Json request = test::small_request(4);
    request["budget"]["seconds"] = 1e-3;
    EXPECT_LE(forecast(read_job(request)).seconds, 1e-3);
}

TEST(Forecast, ItsBytesAreThoseOfTheBake) {
    const Scene scene = test::small_scene();
    const CancelToken cancel;
    const JobSpec job = test::small_job(6);
    const Plan plan = make_plan(scene, job);
    const Pilot pilot = run_pilot(scene, job, plan, LightingState::kAlbedo, cancel);
    double bytes = 0.0;
    for (size_t i = 0; i < 6; ++i) {
        bytes += static_cast<double>(
            bake_probe(scene, job, pilot, {.probe = i}, cancel).files.front().size_bytes);
    }
    const double ratio =
        static_cast<double>(make_forecast(scene, job, plan, 2, cancel).output_bytes) / bytes;
    EXPECT_GT(ratio, 0.8);
    EXPECT_LT(ratio, 1.25);
}

// The atlases need every probe of a grid; a forecast bakes only some.
TEST(Forecast, GridsWithAtlases) {
    const Scene scene = test::small_scene();
    Json request = test::small_request(1);
    const Json position = request["probes"]["list"][0]["position_m"];
    request["probes"] = {{"grids",
                          {{{"id", "g"},
                            {"origin_m", position},
                            {"spacing_m", {0.5, 0.5, 0.5}},
                            {"counts", {4, 2, 2}}}}}};
    request["products"] = {"ddgi"};
    const JobSpec job = read_job(request);
    const Forecast forecast = make_forecast(scene, job, make_plan(scene, job), 2, {});
    EXPECT_EQ(forecast.output_bytes, 16 * kDdgiBytesPerProbe);
    EXPECT_GT(forecast.seconds, 0.0);
}

// A sun is tried in its own light, and what making that took is part of the forecast.
TEST(Forecast, LightingCounts) {
    const Scene scene = test::small_scene();
    Json request = test::small_request(2);
    request["lighting_states"] = {
        {{"id", "noon"},
         {"sun", {{"direction", {0.2, 0.9, 0.3}}, {"irradiance_w_m2", {1, 1, 1}}, {"rays", 4}}}}};
    const JobSpec job = read_job(request);
    const Forecast forecast = make_forecast(scene, job, make_plan(scene, job), 2, {});
    EXPECT_GT(forecast.lighting_seconds, 0.0);
    EXPECT_GT(forecast.seconds, forecast.lighting_seconds);
}

TEST(Forecast, StopsWhenItIsCancelled) {
    const Scene scene = test::small_scene();
    CancelToken cancel;
    cancel.cancel();
    const JobSpec job = test::small_job(2);
    EXPECT_THROW(make_forecast(scene, job, make_plan(scene, job), 1, cancel), Cancelled);
}

}  // namespace
}  // namespace probebake
