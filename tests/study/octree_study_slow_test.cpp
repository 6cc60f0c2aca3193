// The octree study, reduced to 64² pixels, and what is known of its rays at full size.
#include <gtest/gtest.h>

#include "study/octrees/octree_report.h"
#include "study/octrees/spd_rays.h"
#include "support/data.h"

namespace probebake::study {
namespace {

TEST(OctreeStudySlow, ReducedItStaysNearTheTablesOf1999) {
    const auto csv = test::data_file("octrees/havran_1999.csv");
    const auto scene = test::data_file("spd/teapot_s12.nff");
    if (!csv || !scene) GTEST_SKIP() << "no octrees and spd in PROBEBAKE_DATA";
    OctreeStudyParams params{.out = std::filesystem::path(testing::TempDir()) / "probebake-octrees",
                             .data_folder = csv->parent_path().parent_path()};
    params.measure.size_px = 64;
    std::filesystem::remove_all(params.out);
    const OctreeStudyOutcome outcome = run_octree_study(params, [](const StudyProgress&) {});
    ASSERT_TRUE(outcome.left_out.empty()) << outcome.left_out[0];
    EXPECT_EQ(outcome.computed, 9u);

    const Json& counts = outcome.summary.at("center_counts");
    EXPECT_EQ(counts.at("count"), 128);
    EXPECT_EQ(counts.at("exact"), 109);
    EXPECT_LE(counts.at("largest_off").get<double>(), 0.0013);
    // The cost-estimate trees are a reading of the document; of the design's first one the median
    // was 3.7 % off.
    EXPECT_LE(outcome.summary.at("cost_counts").at("median_off").get<double>(), 0.012);
    EXPECT_EQ(outcome.summary.at("disagreements"), 0);
    EXPECT_GT(outcome.summary.at("casts").get<uint64_t>(), 3'000'000u);

    // Figures per ray hang on the size, but not by much: 2.8 % at the most at 64 px.
    const Json as_full = summarise_octrees(HavranTables(*csv), outcome.results, true);
    std::printf("N_TS %.4f off, ratios %.4f and %.4f\n",
                as_full.at("steps_off_of_six").get<double>(),
                as_full.at("ratio_off_89").get<double>(), as_full.at("ratio_off_93").get<double>());
    EXPECT_LE(as_full.at("steps_off_of_six").get<double>(), 0.035);
    EXPECT_LE(as_full.at("ratio_off_89").get<double>(), 0.065);
    EXPECT_LE(as_full.at("ratio_off_93").get<double>(), 0.065);
    // CPU time of a busy machine: the middle of the cases.
    EXPECT_LT(as_full.at("cpu_89").at("median").get<double>(), 0.95);
    EXPECT_LT(as_full.at("cpu_93").at("median").get<double>(), 0.95);
    EXPECT_LT(as_full.at("cpu_93_cost").at("median").get<double>(), 0.95);
    std::filesystem::remove_all(params.out);
}

TEST(OctreeStudySlow, EyeRaysHitAsOftenAsIn1999) {
    for (const HavranRays& theirs : havran_rays()) {
        const std::string name = theirs.scene;
        const auto file =
            test::data_file("spd/" + (name == "teapot" ? "teapot_s12" : name) + ".nff");
        if (!file) GTEST_SKIP() << "no spd/" << name << ".nff in PROBEBAKE_DATA";
        const NffScene scene = read_nff(*file);
        const ObjectOctree octree(scene.shapes, safe_boxes(scene.shapes), {.max_depth = 7});
        const SpdRayCounts ours = count_rays(spd_rays(scene, octree, {.max_depth = 1}));
        EXPECT_EQ(ours.cast[0], theirs.cast[0]) << name;
        // Six scenes to the ray; of mount one more, of tree two.
        EXPECT_NEAR(static_cast<double>(ours.used[0]), static_cast<double>(theirs.used[0]),
                    name == "mount" || name == "tree" ? 2.0 : 0.0)
            << name;
    }
}

}  // namespace
}  // namespace probebake::study
