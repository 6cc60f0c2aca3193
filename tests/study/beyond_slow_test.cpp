// The study of the default renderer, reduced: its ratios have to hold on small worlds, too.
#include <gtest/gtest.h>

#include "study/beyond/beyond.h"

namespace probebake::study {
namespace {

TEST(BeyondSlow, TheDefaultRendererBeatsTheThesissOnFreshWorlds) {
    const auto out = std::filesystem::path(testing::TempDir()) / "probebake-beyond-slow";
    std::filesystem::remove_all(out);
    const BeyondParams params{.out = out,
                              .size = 512,
                              .probes = 2,
                              .scenes = {"desert-23", "forest-41", "mountain-23", "biomes-41"}};
    const BeyondOutcome outcome = run_beyond(params, [](const StudyProgress&) {});
    EXPECT_EQ(outcome.computed, 4u);
    EXPECT_FALSE(outcome.fitted) << "the scenes to fit on were not asked for";
    const auto figure = [&](const char* set, const char* name, const char* which) {
        return outcome.summary.at(set).at(name).at(which).get<double>();
    };
    for (const char* set : {"nadir", "probes"}) {
        std::printf(
            "%s: RMSE over the thesis's at 2x base %.3f (worst %.3f), over A' %.3f; steps "
            "%.3f\n",
            set, figure(set, "rmse over error_aware, 2.0 ×", "mean"),
            figure(set, "rmse over error_aware, 2.0 ×", "worst"),
            figure(set, "rmse over adaptive_black, 2.0 ×", "mean"),
            figure(set, "steps for the thesis's rmse at 4 ×", "mean"));
        // Views of 128² pixels: less of the world is far away than at full size, where the means
        // are lower (docs/results/beyond.md).
        EXPECT_LT(figure(set, "rmse over error_aware, 2.0 ×", "mean"), 0.6) << set;
        EXPECT_LT(figure(set, "rmse over error_aware, 2.0 ×", "worst"), 0.75) << set;
        EXPECT_LT(figure(set, "rmse over adaptive_black, 2.0 ×", "mean"), 0.75) << set;
        EXPECT_LT(figure(set, "rmse over adaptive_black, 4.0 ×", "mean"), 0.75) << set;
        EXPECT_LT(figure(set, "steps for the thesis's rmse at 4 ×", "mean"), 0.3) << set;
    }
    EXPECT_LT(outcome.summary["irradiance"]["mean"].get<double>(), 0.006);
    const BeyondOutcome again = run_beyond(params, [](const StudyProgress&) {});
    EXPECT_EQ(again.computed, 0u);
    EXPECT_EQ(again.results, outcome.results);
    EXPECT_TRUE(std::filesystem::exists(out / "report.md"));
    std::filesystem::remove_all(out);
}

}  // namespace
}  // namespace probebake::study
