// The study, reduced: what it says must not depend on its size.
#include <gtest/gtest.h>

#include "study/report_cells.h"
#include "study/study.h"

namespace probebake::study {
namespace {

/// RMSE against the truth of error-aware over the better adaptive baseline.
double ratio_at(const Json& results, const char* scene, double budget) {
    for (const Json& row : results["equal_steps"][scene]["rows"]) {
        if (row["times_base"] != budget) continue;
        return rmse_of(row["error_aware"], "truth") /
               std::min(rmse_of(row["adaptive"], "truth"), rmse_of(row["adaptive_black"], "truth"));
    }
    return 0.0;
}

void expect_error_aware_to_lose_on_terrain_and_win_on_the_grating(const Json& results) {
    for (const char* terrain : {"desert", "mountain"}) {
        for (const double budget : {2.0, 4.0, 6.0}) {
            EXPECT_GT(ratio_at(results, terrain, budget), 1.0) << terrain << " " << budget;
            EXPECT_LT(ratio_at(results, terrain, budget), 1.6) << terrain << " " << budget;
        }
    }
    EXPECT_LT(ratio_at(results, "grating", 5.0), 0.85);
    EXPECT_LT(ratio_at(results, "grating", 12.0), 0.75);
}

void expect_rays_to_scale_with_fixed_levels(const Json& results) {
    const Json& rows = results["resolutions"]["desert"]["rows"];
    const Json* larger = nullptr;
    int compared = 0;
    for (const Json& row : rows) {
        if (row["level_of_detail"] != "fixed") continue;
        if (larger != nullptr) {
            EXPECT_NEAR(hit_rays_of((*larger)["error_aware"]) / hit_rays_of(row["error_aware"]),
                        4.0, 0.4);
            ++compared;
        }
        larger = &row;
    }
    EXPECT_EQ(compared, 3);
}

void expect_the_beam_to_be_cut_off_by_distance_alone(const Json& results) {
    const Json& modes = results["beam"]["cornell"]["modes"];
    const auto kept = [&](size_t mode) { return modes[mode]["kept"].get<double>(); };
    ASSERT_EQ(modes[1]["mode"], "distance");
    EXPECT_NEAR(modes[1]["lit_until_z"].get<int>(), 350, 10);
    EXPECT_LT(kept(1), 0.75);
    EXPECT_GT(kept(2), 0.90);  // the thesis's settings
    EXPECT_LT(kept(2), 0.97);  // but they lose the far end
    EXPECT_LT(modes[2]["lit_until_z"].get<int>(), 650);
    EXPECT_GT(kept(3), 0.98);
    EXPECT_GT(kept(4), 0.97);
    EXPECT_EQ(modes[4]["lit_until_z"], 890);
}

void expect_levels_of_detail_to_thicken_the_line_and_brighten_the_torch(const Json& results) {
    for (const char* scene : {"slackline", "torch"}) {
        for (const Json& row : results["thin"][scene]["rows"]) {
            const double footprint = row["footprint_voxels"];
            EXPECT_NEAR(row["reference"]["kept"].get<double>(), 1.0, 0.05) << scene << footprint;
            if (footprint < 4.0) continue;
            EXPECT_GT(row["lod"]["kept"].get<double>(), 0.5 * footprint) << scene << footprint;
            EXPECT_LT(row["error_aware"]["kept"].get<double>(), 1.2) << scene << footprint;
        }
    }
}

/// One test, because every test is a process and the study is run once.
TEST(StudySlow, SaysOnSmallWorldsWhatItSaysAtFullSize) {
    const auto out = std::filesystem::path(testing::TempDir()) / "probebake-study-slow";
    std::filesystem::remove_all(out);
    const StudyOutcome outcome =
        run_study({.out = out,
                   .size = 256,
                   .scenes = {"desert", "mountain", "grating", "slackline", "torch", "cornell"},
                   .experiments = {"thresholds", "equal_steps", "resolutions", "beam", "thin"}},
                  [](const StudyProgress&) {});
    std::filesystem::remove_all(out);
    expect_error_aware_to_lose_on_terrain_and_win_on_the_grating(outcome.results);
    expect_rays_to_scale_with_fixed_levels(outcome.results);
    expect_the_beam_to_be_cut_off_by_distance_alone(outcome.results);
    expect_levels_of_detail_to_thicken_the_line_and_brighten_the_torch(outcome.results);
}

}  // namespace
}  // namespace probebake::study
