#include "study/thesis_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "study/thesis_check.h"
#include "support/data.h"

namespace probebake::study {
namespace {

/// Cells by table, row and column. Captions hold commas in quotes; no other field does.
class Csv {
  public:
    explicit Csv(const std::filesystem::path& path) {
        std::ifstream file(path);
        std::string line;
        std::getline(file, line);
        while (std::getline(file, line)) {
            const size_t value_at = line.rfind(',');
            const size_t column_at = line.rfind(',', value_at - 1);
            const size_t row_at = line.rfind(',', column_at - 1);
            const std::string table = line.substr(0, line.find(','));
            cells_[table + "|" + line.substr(row_at + 1, column_at - row_at - 1) + "|" +
                   line.substr(column_at + 1, value_at - column_at - 1)] =
                std::stod(line.substr(value_at + 1));
        }
    }
    double at(const std::string& table, const std::string& row, const std::string& column) {
        const std::string key = table + "|" + row + "|" + column;
        EXPECT_EQ(cells_.count(key), 1u) << key;
        return cells_[key];
    }

  private:
    std::map<std::string, double> cells_;
};

std::string number(double x) {
    std::ostringstream text;
    text << x;
    return text.str();
}

TEST(ThesisTables, AreThoseOfTheCsv) {
    const auto path = test::data_file("tables/mueller_2020_tables.csv");
    if (!path) GTEST_SKIP() << "no tables in PROBEBAKE_DATA";
    Csv csv(*path);
    const auto table = [](int i) { return "5." + std::to_string(i); };
    int first = 2;
    const int times[4][2] = {{18, 20}, {21, 22}, {23, 24}, {25, 26}};
    for (const ThesisArea& area : thesis_areas()) {
        std::string title = area.name;
        title[0] = static_cast<char>(std::toupper(title[0]));
        EXPECT_EQ(csv.at("4.1", "Voxels", title), area.voxels);
        EXPECT_EQ(csv.at("4.1", "Octree Nodes", title), area.octree_nodes);
        const auto check = [&](const std::string& row, const ThesisRenderer& r, int class_table,
                               const std::array<const char*, 4>& columns) {
            EXPECT_EQ(csv.at(table(first), row, "Ray Count"), r.rays);
            EXPECT_EQ(csv.at(table(first), row, "Traversal Steps"), r.steps);
            EXPECT_EQ(csv.at(table(first + 3), row, "PSNR"), r.psnr_db);
            EXPECT_EQ(csv.at(table(first + 3), row, "RMSE"), r.rmse);
            EXPECT_EQ(csv.at(table(first + 3), row, "SSIM"), r.ssim);
            for (size_t i = 0; i < 4; ++i) {
                EXPECT_EQ(csv.at(table(class_table), row, columns[i]), r.classes[i]);
            }
        };
        check("Adaptive", area.adaptive, first + 1,
              {"Didn't Hit", "1 Ray / Pixel", "4 Rays / Pixel", "16 Rays / Pixel"});
        check("Error-Aware", area.error_aware, first + 2,
              {"Didn't Hit", "LOD 2", "LOD 1", "LOD 0"});
        const auto& tables = times[(first - 2) / 4];
        for (int t = 0; t < 4; ++t) {
            const ThesisTimeOfDay& time = area.times[static_cast<size_t>(t)];
            const std::string row = "Time " + std::to_string(t);
            EXPECT_EQ(csv.at(table(tables[0]), row, "Ray Count (A)"), time.adaptive_rays);
            EXPECT_EQ(csv.at(table(tables[0]), row, "Ray Count (EA)"), time.error_aware_rays);
            EXPECT_EQ(csv.at(table(tables[0]), row, "Traversal Steps (A)"), time.adaptive_steps);
            EXPECT_EQ(csv.at(table(tables[0]), row, "Traversal Steps (EA)"),
                      time.error_aware_steps);
            EXPECT_EQ(csv.at(table(tables[1]), row, "RMSE (A)"), time.adaptive_rmse);
            EXPECT_EQ(csv.at(table(tables[1]), row, "RMSE (EA)"), time.error_aware_rmse);
        }
        first += 4;
    }
    for (size_t t = 0; t < 6; ++t) {
        const std::string row = number(kThesisThresholds[t]);
        for (size_t d = 0; d < 6; ++d) {
            EXPECT_EQ(csv.at("5.1", number(kThesisDecays[d]), row), thesis_decay_rays()[d][t]);
        }
        const ThesisThreshold& threshold = thesis_thresholds()[t];
        EXPECT_EQ(csv.at("5.27", row, "Ray Count (EA)"), threshold.rays);
        EXPECT_EQ(csv.at("5.27", row, "Traversal Steps (EA)"), threshold.steps);
        EXPECT_EQ(csv.at("5.28", row, "PSNR (EA)"), threshold.psnr_db);
        EXPECT_EQ(csv.at("5.28", row, "RMSE (EA)"), threshold.rmse);
        EXPECT_EQ(csv.at("5.28", row, "SSIM (EA)"), threshold.ssim);
    }
    for (const ThesisResolution& r : thesis_resolutions()) {
        const std::string row = std::to_string(r.view_px) + "x" + std::to_string(r.view_px);
        EXPECT_EQ(csv.at("5.29", row, "Ray Count (A)"), r.adaptive_rays);
        EXPECT_EQ(csv.at("5.29", row, "Ray Count (EA)"), r.error_aware_rays);
        EXPECT_EQ(csv.at("5.29", row, "Traversal Steps (A)"), r.adaptive_steps);
        EXPECT_EQ(csv.at("5.29", row, "Traversal Steps (EA)"), r.error_aware_steps);
        EXPECT_EQ(csv.at("5.30", row, "RMSE (A)"), r.adaptive_rmse);
        EXPECT_EQ(csv.at("5.30", row, "RMSE (EA)"), r.error_aware_rmse);
    }
}

TEST(ThesisTables, ContradictThemselvesWhereWeSay) {
    const PossibleRays possible = possible_desert_rays();
    EXPECT_EQ(possible.fewest, 209'023u);
    EXPECT_EQ(possible.most, 4'389'483u);
    std::string all;
    for (const std::string& finding : thesis_inconsistencies()) all += finding + "\n";
    for (const char* expected :
         {"682,518/652,518", "5 lie below", "1 above 21", "10 times the rays: forest, biomes",
          "counted on desert, mountain and not on forest, biomes", "−348 (desert), 471 (mountain)",
          "749,468", "20 cases error-aware rendering takes no more steps than adaptive in 10"}) {
        EXPECT_NE(all.find(expected), std::string::npos) << expected << "\n" << all;
    }
    const ThesisOwnCases own = thesis_own_cases();
    EXPECT_NEAR(own.lowest_ratio, 0.662, 0.001);
    EXPECT_NEAR(own.highest_ratio, 0.915, 0.001);
    EXPECT_NEAR(own.mean_ratio, 0.784, 0.001);
}

}  // namespace
}  // namespace probebake::study
