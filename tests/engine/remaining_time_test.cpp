#include "engine/remaining_time.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>
#include <vector>

namespace probebake {
namespace {

UnitTimes::TimePoint at(double seconds) {
    return UnitTimes::TimePoint{} + std::chrono::duration_cast<std::chrono::nanoseconds>(
                                        std::chrono::duration<double>(seconds));
}

constexpr double kPixels = 100.0;

/// What was told at the times of the looks, and what it then took.
struct Coverage {
    int covered = 0;
    int looks = 0;
    double error = 0.0;   // mean of |ln(told / taken)|
    double spread = 0.0;  // mean of ln(high / low)
};

/// Bakes of `units` lognormal units, two at a time on two threads, of which the last one has both;
/// looks when so many are done, while another is under way.
Coverage coverage(double deviation, double thought, size_t units, const std::vector<size_t>& when) {
    Coverage result;
    std::mt19937_64 random(static_cast<uint64_t>(deviation * 100.0) + units);
    std::lognormal_distribution seconds(0.0, deviation);
    for (int bake = 0; bake < 200; ++bake) {
        UnitTimes times;
        times.start(at(0.0), units, kPixels * static_cast<double>(units), thought);
        std::vector<std::pair<double, size_t>> running;  // what it has left to do, which
        std::vector<std::pair<double, RemainingTime>> told;
        size_t begun = 0;
        size_t done = 0;
        double now = 0.0;
        while (done < units) {
            while (running.size() < 2 && begun < units) {
                times.begin_unit(begun, kPixels, at(now));
                running.emplace_back(seconds(random), begun++);
            }
            const auto first = std::min_element(running.begin(), running.end());
            const double work = first->first;
            now += work * static_cast<double>(running.size()) / 2.0;
            times.end_unit(first->second, at(now), true);
            running.erase(first);
            for (auto& [left, unit] : running) left -= work;
            ++done;
            if (std::find(when.begin(), when.end(), done) != when.end()) {
                told.emplace_back(now, *times.left(at(now)));
            }
        }
        for (const auto& [time, guess] : told) {
            const double left = now - time;
            EXPECT_LE(guess.interval.low, guess.seconds);
            EXPECT_GE(guess.interval.high, guess.seconds);
            result.covered += guess.interval.low <= left && left <= guess.interval.high ? 1 : 0;
            result.error += std::abs(std::log(guess.seconds / left));
            result.spread += std::log(guess.interval.high / guess.interval.low);
            ++result.looks;
        }
    }
    result.error /= result.looks;
    result.spread /= result.looks;
    return result;
}

struct Case {
    double deviation;
    double thought;
    double widest;  // ln(high / low), in the mean
};

class RemainingTimeTest : public testing::TestWithParam<Case> {};

TEST_P(RemainingTimeTest, ItsIntervalCovers) {
    const Case& c = GetParam();
    const Coverage found = coverage(c.deviation, c.thought, 40, {1, 3, 10, 20, 30});
    std::cout << found.covered << " of " << found.looks << " covered, error " << found.error
              << ", width " << found.spread << "\n";
    EXPECT_GE(found.covered, 0.94 * found.looks);
    EXPECT_LT(found.spread, c.widest);
}

INSTANTIATE_TEST_SUITE_P(Spreads, RemainingTimeTest,
                         testing::Values(Case{0.3, 0.5, 1.5}, Case{0.7, 0.5, 2.0},
                                         Case{1.0, 2.0, 4.5}, Case{2.0, 2.0, 6.0}));

TEST(RemainingTime, GoesByPixels) {
    UnitTimes times;
    times.start(at(0.0), 3, 600.0, 0.5);
    EXPECT_FALSE(times.left(at(0.0)));
    times.begin_unit(0, 100.0, at(0.0));
    EXPECT_FALSE(times.left(at(0.5)));
    times.end_unit(0, at(1.0), true);
    EXPECT_NEAR(times.left(at(1.0))->seconds, 5.0, 1.5);
    EXPECT_LT(times.left(at(1.0))->interval.low, 3.0);
    EXPECT_GT(times.left(at(1.0))->interval.high, 8.0);
    times.begin_unit(1, 400.0, at(1.0));
    times.end_unit(1, at(5.0), true);
    times.begin_unit(2, 100.0, at(5.0));
    EXPECT_NEAR(times.left(at(5.0))->seconds, 1.0, 0.3);
    times.end_unit(2, at(6.0), true);
    EXPECT_EQ(times.left(at(6.0))->interval.high, 0.0);
}

TEST(RemainingTime, AUnitThatTakesLongMakesItLonger) {
    UnitTimes times;
    times.start(at(0.0), 10, 1000.0, 1.5);
    times.begin_unit(0, 100.0, at(0.0));
    times.begin_unit(1, 100.0, at(0.0));
    times.end_unit(0, at(1.0), true);
    const double early = times.left(at(1.0))->seconds;
    EXPECT_GT(times.left(at(20.0))->seconds, 2.0 * early);
}

TEST(RemainingTime, AUnitThatWasGivenUpTellsNothing) {
    UnitTimes times;
    times.start(at(0.0), 2, 200.0, 0.5);
    times.begin_unit(0, 100.0, at(0.0));
    times.end_unit(0, at(1.0), false);
    EXPECT_FALSE(times.left(at(1.0)));
}

}  // namespace
}  // namespace probebake
