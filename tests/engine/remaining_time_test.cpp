#include "engine/remaining_time.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "math/random.h"

namespace probebake {
namespace {

// 300 bakes of 40 units whose times differ by a factor of e to both sides, on two threads: of the
// intervals after 3, 10 and 30 units at least 95 % hold what it then took.
TEST(RemainingTime, ItsIntervalCovers) {
    int covered = 0;
    int looks = 0;
    int narrow = 0;
    for (uint64_t bake = 0; bake < 300; ++bake) {
        RandomStream random(random_key({bake, 5}));
        std::vector<double> seconds;
        seconds.reserve(40);
        for (int i = 0; i < 40; ++i) seconds.push_back(std::exp(2.0 * random.uniform() - 1.0));
        UnitTimes times;
        double elapsed = 0.0;
        for (size_t i = 0; i < seconds.size(); ++i) {
            times.add(seconds[i], 100.0);
            elapsed += seconds[i] / 2.0;
            const size_t done = i + 1;
            if (done != 3 && done != 10 && done != 30) continue;
            double left = 0.0;
            for (size_t j = done; j < seconds.size(); ++j) left += seconds[j] / 2.0;
            const auto units = static_cast<double>(seconds.size() - done);
            const RemainingTime guess = times.left(elapsed, units, 100.0 * units);
            EXPECT_LE(guess.interval.low, guess.seconds);
            EXPECT_GE(guess.interval.high, guess.seconds);
            covered += guess.interval.low <= left && left <= guess.interval.high ? 1 : 0;
            narrow += std::abs(left - guess.seconds) <= 0.05 * guess.seconds ? 1 : 0;
            ++looks;
        }
    }
    EXPECT_GE(covered, 0.95 * looks);
    EXPECT_LT(narrow, 0.6 * looks) << "an interval of five per cent would not";
}

TEST(RemainingTime, GoesByPixels) {
    UnitTimes times;
    times.add(1.0, 100.0);
    EXPECT_DOUBLE_EQ(times.left(1.0, 1.0, 400.0).seconds, 4.0);
    EXPECT_DOUBLE_EQ(times.left(1.0, 1.0, 400.0).interval.high, 12.0);
    times.add(4.0, 400.0);
    EXPECT_DOUBLE_EQ(times.left(5.0, 2.0, 500.0).seconds, 5.0);
    EXPECT_EQ(times.left(5.0, 0.0, 0.0).seconds, 0.0);
}

}  // namespace
}  // namespace probebake
