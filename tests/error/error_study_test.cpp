#include "error/error_study.h"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "error/sh_error.h"

namespace probebake {
namespace {

constexpr const char* kHeader = "mask,dx,dy,dz,ray_cast,sh9,exact,octant_table";

std::vector<double> numbers(const std::string& line) {
    std::vector<double> values;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(std::stod(cell));
    return values;
}

TEST(ErrorStudy, WritesTheWholeTableByDefault) {
    std::stringstream csv;
    write_error_csv(csv);
    std::string line;
    ASSERT_TRUE(std::getline(csv, line));
    EXPECT_EQ(line, kHeader);
    const std::vector<Vec3> directions = even_directions();
    double largest = 0.0;
    size_t row = 0;
    for (; std::getline(csv, line); ++row) {
        const std::vector<double> cells = numbers(line);
        ASSERT_EQ(cells.size(), 8u);
        const auto mask = static_cast<uint8_t>(row / 256);
        const Vec3& d = directions[row % 256];
        ASSERT_EQ(cells[0], mask);
        ASSERT_EQ(Vec3(cells[1], cells[2], cells[3]), d);
        ASSERT_EQ(cells[5], thesis_error_table().error(d, mask));
        ASSERT_NEAR(cells[4], cells[6], 4.5e-4);
        ASSERT_NEAR(cells[5], cells[6], 0.19);
        ASSERT_NEAR(cells[7], cells[6], 0.062);
        largest = std::max(largest, std::abs(cells[4] - cells[6]));
    }
    EXPECT_EQ(row, 65'536u);
    EXPECT_GT(largest, 0.0);  // two columns, not one written twice
}

TEST(ErrorStudy, WritesTheRowsThatAreAskedFor) {
    std::stringstream csv;
    write_error_csv(csv, {{1, 255}, {Vec3(0, 0, 1), Vec3(0.6, 0, -0.8)}});
    std::vector<std::string> lines;
    for (std::string line; std::getline(csv, line);) lines.push_back(line);
    ASSERT_EQ(lines.size(), 5u);
    EXPECT_EQ(lines[1].rfind("1,0,0,1,0.7", 0), 0u) << lines[1];
    EXPECT_EQ(numbers(lines[1])[6], 0.75);
    EXPECT_EQ(numbers(lines[1])[7], 0.75);
    EXPECT_EQ(lines[2].rfind("1,0.6,0,-0.8,0.7", 0), 0u) << lines[2];
    EXPECT_EQ(lines[3], "255,0,0,1,0,0,0,0");
    EXPECT_EQ(lines[4], "255,0.6,0,-0.8,0,0,0,0");
}

TEST(ErrorStudy, RefusesDirectionsThatAreNotUnitBeforeItWrites) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInf = std::numeric_limits<double>::infinity();
    for (const Vec3& d : {Vec3(0.0), Vec3(1, 1, 1), Vec3(kNan, 0, 0), Vec3(-kInf, 0, 0)}) {
        std::ostringstream csv;
        EXPECT_THROW(write_error_csv(csv, {{7}, {Vec3(1, 0, 0), d}}), std::invalid_argument);
        EXPECT_TRUE(csv.str().empty());
    }
}

TEST(ErrorStudy, ComparesFrameBuffersWithTheThesis) {
    const ErrorAccuracy accuracy = measure_error_accuracy();
    const std::array<double, 4> table_3_1 = {0.75, 0.375, 0.1875, 0.09375};
    for (size_t i = 0; i < 4; ++i) {
        const ErrorAccuracy::FrameBuffer& frame = accuracy.frame_buffers[i];
        EXPECT_EQ(frame.frame_px, 64 << i);
        EXPECT_EQ(frame.thesis_bound, table_3_1[i]);
        EXPECT_GT(frame.ray_cast.rms, 0.0);
        EXPECT_GE(frame.ray_cast.max, frame.ray_cast.rms);
        EXPECT_LT(frame.ray_cast.max, frame.thesis_bound / 50.0);  // the bound is far from tight
    }
    std::ostringstream text;
    print_error_accuracy(text, accuracy);
    for (const char* words : {"frame 64", "0.75", "frame 512", "0.09375", "sh9", "octant_table"}) {
        EXPECT_NE(text.str().find(words), std::string::npos) << words;
    }
}

TEST(ErrorStudy, DeviationIsWhatItSays) {
    ErrorTable exact{{Vec3(0, 0, 1)}, std::vector<MaskErrors>(1)};
    ErrorTable table = exact;
    table.errors[0][3] = -0.5;
    table.errors[0][200] = 0.25;
    const Deviation d = deviation(table, exact);
    EXPECT_DOUBLE_EQ(d.mean, -0.25 / 256.0);
    EXPECT_DOUBLE_EQ(d.rms, std::sqrt(0.3125 / 256.0));
    EXPECT_EQ(d.max, 0.5);
    EXPECT_THROW(deviation(table, ErrorTable{}), std::invalid_argument);
}

}  // namespace
}  // namespace probebake
