#include "bake/error_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "math/random.h"

namespace probebake {
namespace {

TEST(ErrorPrior, WithoutAnAuditThePriorSpeaksWithALargeOneTheAuditDoes) {
    const ErrorPrior prior{.ratio = 0.5, .spread = 0.4, .draw_cv = 4.0};
    const PooledError alone = pooled_error(prior, {.predicted = 2.0}, 0.95);
    EXPECT_NEAR(alone.value, 1.0, 1e-12);
    EXPECT_LT(alone.interval.low, 0.6);
    EXPECT_GT(alone.interval.high, 1.7);
    EXPECT_LT(alone.upper, alone.interval.high);
    const PooledError large =
        pooled_error(prior, {.predicted = 2.0, .measured = 3.0, .draws = 1'000'000}, 0.95);
    EXPECT_NEAR(large.value, 3.0, 0.01);
    EXPECT_NEAR(large.interval.low, 3.0 * (1.0 - 1.96 * 4e-3), 0.01);
    // No error found is no proof of none.
    EXPECT_GT(pooled_error(prior, {.predicted = 2.0, .draws = 30}, 0.95).upper, 0.5);
}

TEST(ErrorPrior, AuditsOfOneProbeAreAddedUpAsOfWhatIsPredictedNow) {
    const AuditedRatio first{.predicted = 2.0, .measured = 4.0, .variance = 1.0, .draws = 10};
    const AuditedRatio second{.predicted = 1.0, .measured = 1.0, .variance = 0.5, .draws = 30};
    const AuditedRatio both = with_further_audit(first, second);
    EXPECT_EQ(both.draws, 40u);
    EXPECT_DOUBLE_EQ(both.predicted, 1.0);
    EXPECT_DOUBLE_EQ(both.measured, 0.75 * 1.0 + 0.25 * 2.0);
    EXPECT_EQ(with_further_audit({}, second).measured, 1.0);
}

TEST(ErrorPrior, WhereAuditsTellWhatToExpectChanceIsAddedToIt) {
    const ErrorPrior prior{.ratio = 1.0, .spread = 0.4, .draw_cv = 4.0};
    AuditedRatio audit{.predicted = 2.0, .measured = 3.0, .draws = 100'000'000};
    audit.chance = std::sqrt(2.0 / 4.0);  // of the mean of four squares of normal variables
    const PooledError large = pooled_error(prior, audit, 0.95);
    EXPECT_NEAR(large.value, 3.0, 1e-3);
    EXPECT_NEAR(large.upper, 3.0 * 9.4877 / 4.0, 0.01);  // chi squared, 0.95 at 4 degrees
    audit.draws = 0;
    const PooledError alone = pooled_error(prior, audit, 0.95);
    audit.chance = 0.0;
    EXPECT_GT(alone.upper, 1.2 * pooled_error(prior, audit, 0.95).upper);
    EXPECT_GT(alone.upper, 1.05 * 2.0 * 9.4877 / 4.0);
}

/// Normal by Box and Muller.
double normal(RandomStream& random) {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - random.uniform()));
    return radius * std::cos(6.283185307179586 * random.uniform());
}

/// Probes whose ratios are lognormal and audits whose draws are, which is not what the model
/// assumes: skewed and heavy-tailed, as errors are.
struct Probes {
    std::vector<double> ratios;
    std::vector<AuditedRatio> audits;
};
Probes simulate(uint64_t key, int count, double spread, double cv, int draws) {
    RandomStream random(random_key({key, 77}));
    const auto lognormal = [&](double mean, double relative) {
        const double s2 = std::log(1.0 + relative * relative);
        return mean * std::exp(std::sqrt(s2) * normal(random) - s2 / 2.0);
    };
    Probes out;
    for (int i = 0; i < count; ++i) {
        out.ratios.push_back(lognormal(0.6, spread));
        Moments moments;
        for (int d = 0; d < draws; ++d) moments.add(lognormal(out.ratios.back(), cv));
        const Estimate mean = Estimate::of_mean(moments);
        out.audits.push_back({.predicted = 1.0,
                              .measured = mean.value,
                              .variance = mean.variance,
                              .draws = mean.samples});
    }
    return out;
}

// 200 jobs of 40 probes: intervals cover in 95 % within two points although the model is not true,
// and the prior is found. Half the spread is noticed.
TEST(ErrorPrior, LearnedFromSixteenProbesItsIntervalsCover) {
    const ErrorPrior before{.ratio = 1.0, .spread = 1.0, .draw_cv = 3.0};
    int covered = 0;
    int covered_narrow = 0;
    int within_upper = 0;
    int count = 0;
    double ratio = 0.0;
    for (uint64_t job = 0; job < 200; ++job) {
        const Probes first = simulate(2 * job, 16, 0.4, 3.0, 60);
        const ErrorPrior prior = learned_prior(before, first.audits);
        ratio += prior.ratio / 200.0;
        const Probes others = simulate(2 * job + 1, 40, 0.4, 3.0, 30);
        ErrorPrior narrow = prior;
        narrow.spread *= 0.5;
        for (size_t i = 0; i < others.ratios.size(); ++i) {
            const double truth = others.ratios[i];
            const PooledError pooled = pooled_error(prior, others.audits[i], 0.95);
            covered += pooled.interval.low <= truth && truth <= pooled.interval.high ? 1 : 0;
            within_upper += truth <= pooled.upper ? 1 : 0;
            const Interval less = pooled_error(narrow, others.audits[i], 0.95).interval;
            covered_narrow += less.low <= truth && truth <= less.high ? 1 : 0;
            ++count;
        }
    }
    EXPECT_NEAR(ratio, 0.6, 0.06);
    EXPECT_GT(covered, 0.93 * count);
    EXPECT_GT(within_upper, 0.93 * count);
    EXPECT_LT(covered_narrow, 0.9 * count);
}

TEST(ErrorPrior, NothingIsLearnedFromNothing) {
    const ErrorPrior before{.ratio = 0.7, .spread = 0.6, .draw_cv = 5.0};
    EXPECT_EQ(learned_prior(before, {}).ratio, 0.7);
    const std::vector<AuditedRatio> black(16, {.predicted = 1.0, .draws = 30});
    EXPECT_EQ(learned_prior(before, black).ratio, 0.7);
}

// Fifteen audits agree with the pilot; one met a pixel that is wrong as few are.
TEST(ErrorPrior, OneAuditDoesNotTurnWhatThePilotFound) {
    const ErrorPrior before{.ratio = 0.8, .spread = 0.7, .draw_cv = 10.0, .common = 0.25};
    std::vector<AuditedRatio> audits(
        16, {.predicted = 1.0, .measured = 0.8, .variance = 0.5, .draws = 60});
    audits.back().measured = 64.0;
    audits.back().variance = 4'000.0;
    const ErrorPrior prior = learned_prior(before, audits);
    EXPECT_GT(prior.ratio, 0.8);
    EXPECT_LT(prior.ratio, 2.4) << "half of the audits' mean, 4.75";
    // All together do.
    for (AuditedRatio& audit : audits) audit = {1.0, 4.75, 4.0, 60};
    EXPECT_GT(learned_prior(before, audits).ratio, 2.4);
}

TEST(ErrorPrior, TheMeanOfProbesVariesByWhatTheyHaveInCommon) {
    // R of a probe = a common factor times one of its own; the mean of their posteriors covers.
    RandomStream random(5);
    std::mt19937_64 engine(7);
    const double common = 0.3;
    const double own = 0.5;
    int covered = 0;
    constexpr int kJobs = 2000;
    const auto inverse_gamma = [&](double spread) {
        const double shape = 2.0 + 1.0 / (spread * spread);
        return (shape - 1.0) / std::gamma_distribution<double>(shape)(engine);
    };
    for (int job = 0; job < kJobs; ++job) {
        std::vector<PooledError> probes;
        double truth = 0.0;
        const double factor = inverse_gamma(common);
        for (int i = 0; i < 40; ++i) {
            const double predicted = 0.5 + random.uniform();
            const double spread = std::hypot(common, own);
            probes.push_back(pooled_error({.spread = spread}, {.predicted = predicted}, 0.95));
            EXPECT_NEAR(probes.back().spread, spread, 1e-9);
            truth += factor * inverse_gamma(own) * predicted / 40.0;
        }
        const PooledError mean = mean_error(probes, common, 0.95);
        covered += truth >= mean.interval.low && truth <= mean.interval.high ? 1 : 0;
        EXPECT_LT(mean.interval.high / mean.interval.low, 4.5);
    }
    EXPECT_GE(covered, 0.95 * kJobs);
}

}  // namespace
}  // namespace probebake
