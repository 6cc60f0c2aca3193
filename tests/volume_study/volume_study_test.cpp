// The study at a small size: tables are whole, and their shape is that of Kutz et al. 2017.
#include "volume_study/volume_study.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace probebake::volume_study {
namespace {

double number(const study::TextTable& table, size_t row, const std::string& column) {
    for (size_t i = 0; i < table.columns.size(); ++i) {
        if (table.columns[i] == column) return std::atof(table.rows.at(row).at(i).c_str());
    }
    ADD_FAILURE() << "no column " << column;
    return 0.0;
}

TEST(VolumeStudy, TablesHaveTheShapeOfThePublishedOnes) {
    const auto out = std::filesystem::temp_directory_path() /
                     ("probebake-volume-study-" + std::to_string(::getpid()));
    const VolumeStudyParams params{.out = out,
                                   .cumulus_size = 96,
                                   .paths = 200,
                                   .samples = 600,
                                   .most_nodes = 300'000,
                                   .experiments = {"depth", "efficiency", "control", "figure_4"}};
    const auto tables = run_volume_study(params, [](const std::string&) {});
    ASSERT_EQ(tables.size(), 9u);
    for (const study::TextTable& table : tables) {
        EXPECT_TRUE(std::filesystem::exists(out / (table.name + ".csv")));
        EXPECT_FALSE(table.rows.empty());
    }
    EXPECT_TRUE(std::filesystem::exists(out / "report.md"));
    for (size_t t = 0; t < 2; ++t) {
        const study::TextTable& depth = tables[t];
        ASSERT_EQ(depth.rows.size(), 4u);
        // The root alone has a minorant of 0: nothing to decompose. Deeper, ever more.
        EXPECT_NEAR(number(depth, 0, "ratio"), 1.0, 0.05);
        EXPECT_LT(number(depth, 2, "ratio"), 0.9);
        EXPECT_LE(number(depth, 3, "ratio"), number(depth, 1, "ratio"));
        EXPECT_LT(number(depth, 3, "delta lookups against depth 1"), 0.5);
        EXPECT_GT(number(depth, 3, "leaves against depth 1"), 1.0);
    }
    for (size_t t = 2; t < 7; ++t) {
        for (size_t row = 0; row < tables[t].rows.size(); ++row) {
            EXPECT_EQ(number(tables[t], row, "faults"), 0.0) << tables[t].name;
        }
    }
    // Gray: one scalar flight for three channels is worth more than a channel at a time.
    EXPECT_GT(number(tables[2], 0, "efficiency by counts"), 1.2);
    // With the minorant no weight is anything but 1; lookups fall as the control rises.
    const study::TextTable& control = tables[7];
    for (const size_t first : {size_t{0}, size_t{10}}) {
        EXPECT_EQ(control.rows.at(first).at(1), "minorant");
        EXPECT_EQ(number(control, first, "mean w"), 1.0);
        EXPECT_EQ(number(control, first, "variance of w"), 0.0);
        EXPECT_LT(number(control, first + 5, "ρ = N_dcmp / N_delta"), 0.7);
        EXPECT_GT(number(control, first + 5, "variance of w"), 0.0);
    }
    std::filesystem::remove_all(out);
}

}  // namespace
}  // namespace probebake::volume_study
