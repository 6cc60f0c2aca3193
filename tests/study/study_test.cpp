#include "study/study.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "io/file.h"
#include "study/report_cells.h"
#include "study/result_store.h"
#include "study/study_scenes.h"

namespace probebake::study {
namespace {

class StudyTest : public testing::Test {
  protected:
    void SetUp() override {
        const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        params_.out = std::filesystem::path(testing::TempDir()) / ("probebake-study-" + test);
        std::filesystem::remove_all(params_.out);
        params_.size = kSmallestSize;
        params_.scenes = {"desert", "grating", "worldA"};
        params_.experiments = {"rendering", "threshold_decay", "thresholds", "equal_steps",
                               "resolutions"};
    }
    void TearDown() override { std::filesystem::remove_all(params_.out); }

    StudyOutcome run() const {
        return run_study(params_, [](const StudyProgress&) {});
    }
    std::vector<std::string> lines(const std::string& file) const {
        std::ifstream stream(params_.out / file);
        std::vector<std::string> all;
        for (std::string line; std::getline(stream, line);) all.push_back(line);
        return all;
    }
    StudyParams params_;
};

TEST_F(StudyTest, ASecondRunComputesNothing) {
    const StudyOutcome first = run();
    EXPECT_EQ(first.computed, 7u);  // 5 on the desert, 2 on the grating
    EXPECT_EQ(first.found, 0u);
    ASSERT_EQ(first.left_out.size(), 1u);
    EXPECT_EQ(first.left_out[0].substr(0, 7), "worldA:");
    const std::vector<std::byte> report = read_file(params_.out / "report.md");

    const StudyOutcome second = run();
    EXPECT_EQ(second.computed, 0u);
    EXPECT_EQ(second.found, 7u);
    EXPECT_EQ(second.results, first.results);
    EXPECT_EQ(read_file(params_.out / "report.md"), report);

    // A lost and a damaged result are computed again, to the same figures.
    std::filesystem::remove(params_.out / "results/thresholds-desert.json");
    write_file_atomically(params_.out / "results/equal_steps-grating.json", std::string("{"));
    const StudyOutcome third = run();
    EXPECT_EQ(third.computed, 2u);
    EXPECT_EQ(third.results, first.results);

    // Another size is another result.
    params_.size = 2 * kSmallestSize;
    params_.experiments = {"thresholds"};
    params_.scenes = {"desert"};
    EXPECT_EQ(run().computed, 1u);
}

TEST_F(StudyTest, AnInterruptedTimeOfDayGoesOnBehindTheLastOne) {
    params_.scenes = {"desert"};
    params_.experiments = {"times_of_day"};
    const StudyOutcome first = run();
    ASSERT_EQ(first.results["times_of_day"]["desert"]["rows"].size(), 4u);
    // As an interruption in the third of four times leaves it.
    std::filesystem::remove(params_.out / "results/times_of_day-desert.json");
    std::filesystem::remove(params_.out / "results/times_of_day-desert.2.json");
    std::filesystem::remove(params_.out / "results/times_of_day-desert.3.json");
    std::vector<std::string> computed;
    const StudyOutcome second =
        run_study(params_, [&](const StudyProgress& p) { computed.push_back(p.what); });
    EXPECT_EQ(second.results, first.results);
    EXPECT_EQ(computed,
              (std::vector<std::string>{"times_of_day, desert", "times_of_day, desert, part 2",
                                        "times_of_day, desert, part 3"}));
}

TEST_F(StudyTest, FiguresAreOrderedAsTheyMustBe) {
    const StudyOutcome outcome = run();
    const Json& rows = outcome.results["thresholds"]["desert"]["rows"];
    for (size_t i = 1; i < rows.size(); ++i) {
        EXPECT_GE(hit_rays_of(rows[i]), hit_rays_of(rows[i - 1]));
        EXPECT_LE(rmse_of(rows[i], "reference"), rmse_of(rows[i - 1], "reference"));
    }
    EXPECT_GT(hit_rays_of(rows.back()), 1.2 * hit_rays_of(rows.front()));
    const Json& renderers = outcome.results["rendering"]["desert"]["renderers"];
    const double reference = rmse_of(renderer_row(renderers, "reference"), "truth");
    const double error_aware = rmse_of(renderer_row(renderers, "error_aware"), "truth");
    const double lod = rmse_of(renderer_row(renderers, "lod"), "truth");
    EXPECT_LT(reference, error_aware);
    EXPECT_LT(error_aware, lod);
    for (const char* adaptive : {"adaptive", "adaptive_black"}) {
        const Json& row = renderer_row(renderers, adaptive);
        EXPECT_LE(steps_of(row), steps_of(renderer_row(renderers, "error_aware")));
        EXPECT_GT(steps_of(row), 0.95 * steps_of(renderer_row(renderers, "error_aware")));
    }
}

TEST_F(StudyTest, TablesHaveAllRowsAndColumns) {
    run();
    const std::pair<const char*, std::pair<size_t, size_t>> shapes[] = {
        {"scenes", {2, 5}},
        {"rendering_ratios", {2, 8}},
        {"rendering", {10, 15}},
        {"threshold_decay", {8, 8}},
        {"decays", {1, 9}},
        {"thresholds", {6, 7}},
        {"equal_steps_truth", {4, 9}},
        {"resolutions", {6, 7}}};
    for (const auto& [name, shape] : shapes) {
        const auto table = lines("tables/" + std::string(name) + ".csv");
        ASSERT_EQ(table.size(), shape.first + 1) << name;
        for (const std::string& line : table) {
            size_t cells = 1;
            bool quoted = false;
            for (const char c : line) {
                if (c == '"') quoted = !quoted;
                if (c == ',' && !quoted) ++cells;
            }
            EXPECT_EQ(cells, shape.second) << name << ": " << line;
        }
    }
    // A reduced run says so everywhere and shows no figures of the thesis.
    std::string report;
    for (const std::string& line : lines("report.md")) {
        if (line.substr(0, 2) == "# ") {
            EXPECT_NE(line.find("(size 128)"), std::string::npos) << line;
        }
        if (line.substr(0, 2) == "**") {
            EXPECT_NE(line.find("(size 128)"), std::string::npos) << line;
            EXPECT_EQ(line.find("in brackets the thesis"), std::string::npos) << line;
        }
        report += line + "\n";
    }
    EXPECT_NE(report.find("does not hold"), std::string::npos);
    for (const char* picture : {"view", "error-aware-rays", "adaptive-rays"}) {
        EXPECT_TRUE(std::filesystem::exists(params_.out / "pictures" /
                                            ("desert-" + std::string(picture) + ".png")));
    }
    EXPECT_TRUE(std::filesystem::exists(params_.out / "plots/equal_steps.gp"));
}

TEST_F(StudyTest, UnknownNamesAndSizesAreRefused) {
    params_.size = 200;
    EXPECT_THROW(run(), std::invalid_argument);
    params_.size = 4096;
    EXPECT_THROW(run(), std::invalid_argument);
    params_.size = kSmallestSize;
    params_.scenes = {"atlantis"};
    EXPECT_THROW(run(), std::invalid_argument);
    params_.scenes = {"desert"};
    params_.experiments = {"alchemy"};
    EXPECT_THROW(run(), std::invalid_argument);
}

TEST(StudyView, CoversFourVoxelsPerPixelAboveTheMeanGround) {
    std::vector<StudyScene> scenes = study_scenes(256, std::nullopt);
    const Scene scene = load_scene(scenes[0].file);
    const View view = study_view(scene, 256);
    EXPECT_EQ(view.width_px, 64);
    EXPECT_EQ(view.forward, Vec3(0, -1, 0));
    EXPECT_NEAR(view.pixel_spacing() * 128.0, 4.0, 1e-9);
    double sum = 0.0;
    int hits = 0;
    for (int z = 0; z < 256; z += 3) {
        for (int x = 0; x < 256; x += 3) {
            const Hit hit = trace(scene.tree, {Vec3(x + 0.5, 300.0, z + 0.5), Vec3(0, -1, 0)});
            if (!hit) continue;
            sum += 300.0 - hit.t;
            ++hits;
        }
    }
    EXPECT_NEAR(view.origin.y - 128.0, sum / hits, 3.0);
    EXPECT_NE(view.origin.x, std::floor(view.origin.x));
    // Fewer pixels look at the same.
    const View quarter = study_view(scene, 256, 16);
    EXPECT_EQ(quarter.origin, view.origin);
    EXPECT_NEAR(quarter.pixel_spacing(), 4.0 * view.pixel_spacing(), 1e-12);
}

TEST(ResultStoreTest, FindsOnlyWhatHasTheSameKey) {
    const auto folder = std::filesystem::path(testing::TempDir()) / "probebake-store";
    std::filesystem::remove_all(folder);
    const ResultStore store(folder);
    const Json key = {{"size", 4}, {"threshold", 0.154}};
    EXPECT_FALSE(store.find("a", key).has_value());
    store.put("a", key, {{"rmse", 0.1}});
    EXPECT_EQ(store.find("a", key), Json({{"rmse", 0.1}}));
    EXPECT_FALSE(store.find("a", {{"size", 5}, {"threshold", 0.154}}).has_value());
    EXPECT_FALSE(store.find("b", key).has_value());
    write_file_atomically(folder / "a.json", std::string("[1, 2"));
    EXPECT_FALSE(store.find("a", key).has_value());
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace probebake::study
