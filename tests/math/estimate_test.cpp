#include "math/estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "math/random.h"

namespace probebake {
namespace {

TEST(Moments, AgreeWithTwoPasses) {
    RandomStream random(1);
    std::vector<double> xs;
    Moments moments;
    for (int i = 0; i < 1000; ++i) {
        xs.push_back(std::pow(random.uniform(), 4.0));
        moments.add(xs.back());
    }
    double mean = 0.0;
    for (const double x : xs) mean += x / 1000.0;
    double m2 = 0.0;
    double m3 = 0.0;
    for (const double x : xs) {
        m2 += (x - mean) * (x - mean);
        m3 += std::pow(x - mean, 3.0);
    }
    EXPECT_NEAR(moments.mean(), mean, 1e-13);
    EXPECT_NEAR(moments.variance(), m2 / 999.0, 1e-13);
    EXPECT_NEAR(moments.third_moment(), m3 / 1000.0, 1e-13);
}

TEST(Estimate, StudentQuantiles) {  // tables of Student's t
    EXPECT_NEAR(student_t_quantile(0.975, 1), 12.7062, 1e-4);
    EXPECT_NEAR(student_t_quantile(0.975, 10), 2.22814, 1e-5);
    EXPECT_NEAR(student_t_quantile(0.95, 100), 1.66023, 1e-5);
}

/// What share of 95 % intervals from n samples of draw() holds the true mean.
template <class Draw>
double coverage(Draw draw, double mean, int n, uint64_t seed, double shift = 0.0) {
    constexpr int kRuns = 4000;
    int covered = 0;
    for (int run = 0; run < kRuns; ++run) {
        RandomStream random(random_key({seed, static_cast<uint64_t>(run)}));
        Moments moments;
        for (int i = 0; i < n; ++i) moments.add(draw(random));
        const Interval interval = Estimate::of_mean(moments).interval(0.95);
        if (interval.low <= mean + shift && mean + shift <= interval.high) ++covered;
    }
    return static_cast<double>(covered) / kRuns;
}

// 4,000 runs tell a coverage of 0.95 from 0.936 (4 standard errors).
TEST(Estimate, IntervalsCoverSymmetricAndSkewedMeans) {
    const auto uniform = [](RandomStream& r) { return r.uniform(); };
    EXPECT_NEAR(coverage(uniform, 0.5, 30, 1), 0.95, 0.015);
    const auto exponential = [](RandomStream& r) { return -std::log(1.0 - r.uniform()); };
    EXPECT_NEAR(coverage(exponential, 1.0, 60, 2), 0.95, 0.015);
    // Squared errors of a render: three quarters exact, the rest squares of an exponential.
    const auto errors = [](RandomStream& r) {
        const double x = -std::log(1.0 - r.uniform());
        return r.uniform() < 0.75 ? 0.0 : x * x;
    };
    EXPECT_GT(coverage(errors, 0.5, 250, 3), 0.925);
    // A mean that is off by 20 % must not be covered.
    EXPECT_LT(coverage(exponential, 1.0, 1000, 4, 0.2), 0.05);
}

TEST(Estimate, APooledEstimateIsTheWeightedSumOfItsParts) {
    // Two strata of different spread: the pooled interval must cover as well.
    constexpr int kRuns = 4000;
    int covered = 0;
    for (int run = 0; run < kRuns; ++run) {
        RandomStream random(random_key({9, static_cast<uint64_t>(run)}));
        Moments narrow;
        Moments wide;
        for (int i = 0; i < 40; ++i) narrow.add(random.uniform());
        for (int i = 0; i < 60; ++i) wide.add(-10.0 * std::log(1.0 - random.uniform()));
        Estimate pooled;
        pooled.add(0.25, Estimate::of_mean(narrow));
        pooled.add(0.75, Estimate::of_mean(wide));
        const Interval interval = pooled.interval(0.95);
        const double mean = 0.25 * 0.5 + 0.75 * 10.0;
        if (interval.low <= mean && mean <= interval.high) ++covered;
        EXPECT_EQ(pooled.samples, 100u);
    }
    EXPECT_NEAR(static_cast<double>(covered) / kRuns, 0.95, 0.015);
}

TEST(Estimate, TooFewOrEqualSamples) {
    Moments moments;
    moments.add(3.0);
    EXPECT_TRUE(std::isinf(Estimate::of_mean(moments).interval(0.95).high));
    moments.add(3.0);
    const Interval exact = Estimate::of_mean(moments).interval(0.95);
    EXPECT_EQ(exact.low, 3.0);
    EXPECT_EQ(exact.high, 3.0);
    EXPECT_FALSE(Estimate::of_mean(moments).nothing_found());
    Moments zeros;
    for (int i = 0; i < 59; ++i) zeros.add(0.0);
    EXPECT_TRUE(Estimate::of_mean(zeros).nothing_found());
    Estimate nothing = Estimate::of_mean(zeros);
    EXPECT_EQ(nothing.interval(0.95).high, 0.0);  // as far as is known
    nothing.largest = 100.0;
    nothing.told = 2995;
    EXPECT_EQ(nothing.interval(0.95).low, 0.0);
    EXPECT_NEAR(nothing.interval(0.95).high, 0.1, 1e-4);
    Estimate below = nothing;  // squares, by two means each: less than nothing was found
    below.value = -3.0;
    below.variance = 0.1;
    EXPECT_NEAR(below.interval(0.95).high, 0.1, 1e-4);
    EXPECT_NEAR(unseen_share(59, 0.95), 0.0495, 1e-4);
    EXPECT_NEAR(unseen_share(2995, 0.95), 0.001, 1e-6);
}

}  // namespace
}  // namespace probebake
