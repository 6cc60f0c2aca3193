// The study at a small size: tables are whole, and their shape is that of Kutz et al. 2017. Weights
// of history-aware average sum to 3 exactly but for rounding, which four digits do not show.
#include "volume_study/volume_study.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace probebake::volume_study {
namespace {

double number(const study::TextTable& table, size_t row, const std::string& column) {
    for (size_t i = 0; i < table.columns.size(); ++i) {
        if (table.columns[i] == column) return std::atof(table.rows.at(row).at(i).c_str());
    }
    ADD_FAILURE() << "no column " << column;
    return 0.0;
}

const study::TextTable& named(const std::vector<study::TextTable>& tables,
                              const std::string& name) {
    for (const study::TextTable& table : tables) {
        if (table.name == name) return table;
    }
    throw std::out_of_range("no table " + name);
}

class VolumeStudy : public testing::Test {
  protected:
    VolumeStudy()
        : out_(std::filesystem::temp_directory_path() /
               ("probebake-volume-study-" + std::to_string(::getpid()))) {}
    ~VolumeStudy() override { std::filesystem::remove_all(out_); }

    /// Every table is there as CSV, and none is empty.
    std::vector<study::TextTable> run(const std::vector<std::string>& experiments) const {
        const VolumeStudyParams params{.out = out_,
                                       .cumulus_size = 96,
                                       .paths = 200,
                                       .samples = 600,
                                       .side = 12,
                                       .reference = 256,
                                       .most_nodes = 300'000,
                                       .experiments = experiments};
        auto tables = run_volume_study(params, [](const std::string&) {});
        for (const study::TextTable& table : tables) {
            EXPECT_TRUE(std::filesystem::exists(out_ / (table.name + ".csv")));
            EXPECT_FALSE(table.rows.empty());
            for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
        }
        EXPECT_TRUE(std::filesystem::exists(out_ / "report.md"));
        return tables;
    }

    std::filesystem::path out_;
};

TEST_F(VolumeStudy, DepthsHaveTheShapeOfThePublishedTables) {
    const auto tables = run({"depth"});
    ASSERT_EQ(tables.size(), 4u);
    for (const char* thickness : {"thin", "thick"}) {
        const std::string name = std::string("cumulus_96_") + thickness + "_depth";
        const study::TextTable& depth = named(tables, name);
        ASSERT_EQ(depth.rows.size(), 4u);
        // The root alone has a minorant of 0: nothing to decompose. Deeper, ever more.
        EXPECT_NEAR(number(depth, 0, "ratio"), 1.0, 0.05);
        EXPECT_LT(number(depth, 2, "ratio"), 0.9);
        EXPECT_LE(number(depth, 3, "ratio"), number(depth, 1, "ratio"));
        EXPECT_LT(number(depth, 3, "delta lookups against depth 1"), 0.5);
        EXPECT_GT(number(depth, 3, "leaves against depth 1"), 1.0);
        EXPECT_TRUE(std::filesystem::exists(out_ / (name + ".gp")));
        const study::TextTable& times = named(tables, name + "_times");
        ASSERT_EQ(times.rows.size(), 8u);  // two trackers
        for (size_t row = 0; row < 8; ++row) {
            EXPECT_GT(number(times, row, "all ms"), 0.0);
        }
    }
}

TEST_F(VolumeStudy, TrackersCompareAsPublished) {
    const auto tables = run({"efficiency", "control", "figure_4"});
    ASSERT_EQ(tables.size(), 7u);
    for (size_t t = 0; t < 5; ++t) {
        for (size_t row = 0; row < tables[t].rows.size(); ++row) {
            EXPECT_EQ(number(tables[t], row, "faults"), 0.0) << tables[t].name;
        }
    }
    // Gray: one scalar flight for three channels is worth more than a channel at a time.
    EXPECT_GT(number(tables[0], 0, "efficiency by counts"), 1.2);
    // With the minorant no weight is anything but 1; lookups fall as the control rises.
    const study::TextTable& control = named(tables, "control");
    for (const size_t first : {size_t{0}, size_t{10}}) {
        EXPECT_EQ(control.rows.at(first).at(1), "minorant");
        EXPECT_EQ(number(control, first, "mean w"), 1.0);
        EXPECT_EQ(number(control, first, "variance of w"), 0.0);
        EXPECT_LT(number(control, first + 5, "ρ = N_dcmp / N_delta"), 0.7);
        EXPECT_GT(number(control, first + 5, "variance of w"), 0.0);
    }
    EXPECT_TRUE(std::filesystem::exists(out_ / "control.gp"));
    // The maximum scheme, its gap left to absorption, keeps throughputs at 1.
    const study::TextTable& first_flights = named(tables, "figure_4");
    ASSERT_EQ(first_flights.rows.size(), 7u);
    for (const size_t row : {size_t{3}, size_t{4}}) {
        EXPECT_LE(number(first_flights, row, "largest throughput"), 1.0);
        EXPECT_LT(number(first_flights, row, "variance G"),
                  0.7 * number(first_flights, 1, "variance G"));
    }
}

TEST_F(VolumeStudy, RaysToEmittersAreComparedWithChance) {
    const auto tables = run({"emitters"});
    const study::TextTable& table = named(tables, "emitters");
    ASSERT_EQ(table.rows.size(), 12u);
    for (size_t row = 0; row < 10; ++row) EXPECT_GT(number(table, row, "cost, counted"), 1.0);
    EXPECT_EQ(table.rows[11].back(), "left out");
}

TEST_F(VolumeStudy, PicturesGetWorseAsPublished) {
    const auto tables = run({"figure_6", "figure_7"});
    const study::TextTable& unbounded = named(tables, "figure_6");
    ASSERT_EQ(unbounded.rows.size(), 12u);
    for (const size_t first : {size_t{0}, size_t{6}}) {
        EXPECT_LE(number(unbounded, first, "largest absolute throughput"), 3.0);
        EXPECT_GT(number(unbounded, first + 5, "RMSE"), 5.0 * number(unbounded, first, "RMSE"));
    }
    for (size_t row = 0; row < 12; ++row) EXPECT_EQ(number(unbounded, row, "faults"), 0.0);
    const study::TextTable& schemes = named(tables, "figure_7");
    ASSERT_EQ(schemes.rows.size(), 2u);
    EXPECT_GT(number(schemes, 0, "largest throughput"), 3.0);
    EXPECT_LE(number(schemes, 1, "largest throughput"), 3.0);
    EXPECT_TRUE(std::filesystem::exists(out_ / "figure_6.png"));
    EXPECT_TRUE(std::filesystem::exists(out_ / "figure_7.png"));
}

TEST_F(VolumeStudy, ErrorFallsWithRunTime) {
    const study::TextTable curves = run({"curves"}).at(0);
    // Gray media have a row of their own for scalar delta tracking.
    ASSERT_EQ(curves.rows.size(), size_t{5 * (5 * 11) + 5});
    for (size_t row = 0; row < curves.rows.size(); ++row) {
        EXPECT_EQ(number(curves, row, "faults"), 0.0);
        const std::string& tracker = curves.rows[row].at(1);
        if (curves.rows[row].at(2) != "256") continue;
        EXPECT_GT(number(curves, row, "M counted"), 100.0 * number(curves, row - 4, "M counted"));
        if (tracker == "history_average" || tracker == "spectral_mis") {
            EXPECT_LT(number(curves, row, "RMSE"), 0.3 * number(curves, row - 4, "RMSE"));
        }
    }
    EXPECT_TRUE(std::filesystem::exists(out_ / "error_against_time_gray.gp"));
}

}  // namespace
}  // namespace probebake::volume_study
