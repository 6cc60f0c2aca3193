// The study of promises, reduced: on small worlds, too, most of what is said is true, audits are
// cheap, and a second run computes nothing.
#include <gtest/gtest.h>

#include "study/calibration/calibration.h"
#include "study/calibration/calibration_report.h"

namespace probebake::study {
namespace {

TEST(CalibrationSlow, PromisesAreKeptOnSmallWorlds) {
    const auto out = std::filesystem::path(testing::TempDir()) / "probebake-calibration-slow";
    std::filesystem::remove_all(out);
    const CalibrationParams params{
        .out = out, .size = 256, .share = 1.0, .scenes = {"desert", "forest"}, .faces = {16}};
    const CalibrationOutcome outcome = run_calibration(params, [](const StudyProgress&) {});
    EXPECT_EQ(outcome.computed, 4u);
    const Json& all = outcome.summary.at("all");
    std::printf("%s\n", dump_json(all, 1).c_str());
    EXPECT_GE(all.at("results").get<int>(), 400);
    // One-sided binomial test at 1 %.
    EXPECT_TRUE(all.at("met_where_said").at("holds").get<bool>());
    EXPECT_TRUE(all.at("pooled_interval_covers").at("holds").get<bool>());
    EXPECT_LT(all.at("pooled_interval_high_over_low").get<double>(), 4.0);
    EXPECT_LT(all.at("audit_over_render").get<double>(), 0.15);
    EXPECT_LT(all.at("pilot_over_render").get<double>(), 0.15);
    const CalibrationOutcome again = run_calibration(params, [](const StudyProgress&) {});
    EXPECT_EQ(again.computed, 0u);
    EXPECT_EQ(again.results, outcome.results);
    EXPECT_TRUE(std::filesystem::exists(out / "report.md"));
    std::filesystem::remove_all(out);
}

// A study that could not fail would show nothing: where promised bounds are not kept, the test of
// the shares says so.
TEST(CalibrationSlow, ProbesMayBeJobsOfTheirOwn) {
    const auto run = [](const char* folder, std::optional<int> probes_per_job) {
        const auto out = std::filesystem::path(testing::TempDir()) / folder;
        std::filesystem::remove_all(out);
        const CalibrationOutcome outcome = run_calibration({.out = out,
                                                            .size = 128,
                                                            .share = 0.06,
                                                            .scenes = {"desert"},
                                                            .faces = {16},
                                                            .probes_per_job = probes_per_job},
                                                           [](const StudyProgress&) {});
        std::filesystem::remove_all(out);
        return outcome.results.at("desert-16-albedo");
    };
    const Json together = run("probebake-calibration-together", std::nullopt);
    const Json alone = run("probebake-calibration-alone", 1);
    ASSERT_EQ(together["rows"].size(), 6u);
    ASSERT_EQ(alone["rows"].size(), 6u);
    // Every job has a pilot of its own, and none learns from another.
    EXPECT_GT(alone["pilot_steps"].get<double>(), 3.0 * together["pilot_steps"].get<double>());
    // The cheapest price of one probe is that probe's.
    double cheapest = 0.0;
    for (const Json& row : alone["rows"]) cheapest += row["cheapest_steps"].get<double>();
    EXPECT_DOUBLE_EQ(alone["one_price_steps"].get<double>(), cheapest);
}

TEST(CalibrationSlow, ABrokenPromiseIsSeen) {
    EXPECT_LT(binomial_tail(1870, 2000, 0.95), 0.01);  // 93.5 %
    EXPECT_GT(binomial_tail(1880, 2000, 0.95), 0.01);  // 94.0 %
    EXPECT_NEAR(binomial_tail(0, 1, 0.95), 0.05, 1e-12);
    Json rows = Json::array();
    for (int i = 0; i < 200; ++i) {
        rows.push_back({{"met", true},
                        {"by_probe", false},
                        {"looks", 1},
                        {"mse", i < 20 ? 2e-4 : 0.5e-4},
                        {"estimate", 0.5e-4},
                        {"interval", {0.2e-4, 1e-4}},
                        {"render_steps", 10},
                        {"replaced_steps", 0},
                        {"audit_steps", 1},
                        {"cheapest_steps", 8}});
    }
    const Json job = {{"allowed", 1e-4},        {"pilot_steps", 10},
                      {"one_price_steps", 100}, {"one_price_for_the_mean_steps", 100},
                      {"rows", rows},           {"scene", "x"},
                      {"face_size_px", 16},     {"lit", false}};
    const Json all = summarise_calibration({{"x", job}}).at("all");
    EXPECT_FALSE(all["met_where_said"]["holds"].get<bool>());
    EXPECT_FALSE(all["own_interval_covers"]["holds"].get<bool>());
    EXPECT_NEAR(all["over_cheapest_of_each"]["render"].get<double>(), 1.25, 1e-9);
}

}  // namespace
}  // namespace probebake::study
