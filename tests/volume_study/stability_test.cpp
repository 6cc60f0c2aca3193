#include "volume_study/stability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace probebake::volume_study {
namespace {

void expect_all_pass(const std::vector<StabilityCase>& cases, size_t least) {
    EXPECT_GE(cases.size(), least);
    for (const StabilityCase& one : cases) {
        EXPECT_TRUE(one.pass) << one.name << ": " << one.checked << " " << one.value << ", bound "
                              << one.bound;
    }
}

TEST(Stability, EveryCaseOfMediaHolds) { expect_all_pass(media_cases(), 50); }

TEST(Stability, EveryCaseOfVoxelsHolds) { expect_all_pass(voxel_cases(), 60); }

TEST(Stability, NumbersThatAreNoneAreRefusedEverywhere) { expect_all_pass(input_cases(), 10); }

TEST(Stability, CasesCanFail) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(at_most("", "", nan, 1.0).pass);
    EXPECT_FALSE(at_least("", "", nan, 1.0).pass);
    Moments moments;
    for (int i = 0; i < 1000; ++i) moments.add(i % 2);
    EXPECT_TRUE(unbiased("", "", moments, 0.52).pass);
    EXPECT_FALSE(unbiased("", "", moments, 0.6).pass);
    moments.add(nan);
    EXPECT_FALSE(unbiased("", "", moments, 0.5).pass);
}

}  // namespace
}  // namespace probebake::volume_study
