#include "bake/error_prior.h"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/gamma.hpp>
#include <cmath>

namespace probebake {
namespace {

/// What the usual figure of a pixel's spread counts for, in probes, beside a job's own.
constexpr double kUsualProbes = 8.0;
/// Standard deviation of the logarithm of the squared spread, over jobs.
constexpr double kUsualSpreadSpread = 0.8;
constexpr double kSmallestSpread = 0.1;
/// Relative standard deviation of a pilot's ratio at least, whatever its pixels say: a sample of
/// heavy tails shows too little of them.
constexpr double kBestKnownBefore = 1.0 / 3.0;

/// Of the doubt of an interval, what its quantiles may spend: a gamma distribution's tails are
/// thinner than those of errors. Spending all of it covers 91.5 % where 95 % are meant
/// (docs/results/calibration.md).
constexpr double kTailShare = 1.0 / 3.0;

constexpr double kPoorestEstimate = 0.7;

double square(double x) { return x * x; }

}  // namespace

bool tells(const Estimate& sampled) {
    return sampled.value > 0.0 && sampled.standard_error() <= kPoorestEstimate * sampled.value;
}

ErrorPrior learned_prior(const ErrorPrior& before, std::span<const AuditedRatio> audits) {
    double count = 0.0;
    double ratio = 0.0;
    double variance_per_draw = 0.0;
    double per_draw = 0.0;
    double noise = 0.0;  // variance of a measured ratio for its audit's sake, mean
    for (const AuditedRatio& audit : audits) {
        if (!(audit.predicted > 0.0) || audit.draws < 2) continue;
        count += 1.0;
        per_draw += 1.0 / static_cast<double>(audit.draws);
        ratio += audit.measured / audit.predicted;
        const double variance = audit.variance / square(audit.predicted);
        noise += variance;
        variance_per_draw += variance * static_cast<double>(audit.draws);
    }
    if (count < 2.0) return before;
    ratio /= count;
    noise /= count;
    variance_per_draw /= count;
    if (!(ratio > 0.0)) return before;
    double scatter = 0.0;
    for (const AuditedRatio& audit : audits) {
        if (!(audit.predicted > 0.0) || audit.draws < 2) continue;
        scatter += square(audit.measured / audit.predicted - ratio) / (count - 1.0);
    }
    // A sample of heavy tails shows too little of them rather than too much.
    const double weight = count / (count + kUsualProbes);
    const double draw_cv =
        std::max(before.draw_cv, std::sqrt(weight * variance_per_draw / square(ratio) +
                                           (1.0 - weight) * square(before.draw_cv)));
    const double of_audit = std::max(noise / square(ratio), square(draw_cv) * per_draw / count);
    // What audits as noisy as these tell of how probes differ, beside what is usual: both in
    // logarithms.
    const double own = std::max(0.0, scatter - noise) / square(ratio);
    const double own_error =
        std::max(scatter / square(ratio), of_audit) * std::sqrt(2.0 / (count - 1.0));
    double between = square(kUsualSpread);
    if (own > 0.0) {
        const double trust =
            square(kUsualSpreadSpread) / (square(kUsualSpreadSpread) + square(own_error / own));
        between = std::exp(trust * std::log(own) + (1.0 - trust) * std::log(between));
    }
    const double of_audits = (between + of_audit) / count;
    // One of the audits may hold a pixel that is wrong as few are: what was known before counts,
    // too.
    const double known =
        before.common > 0.0 ? 1.0 / square(std::max(before.common, kBestKnownBefore)) : 0.0;
    const double of_ratio = 1.0 / (1.0 / of_audits + known);
    return {.ratio = of_ratio * (ratio / of_audits + before.ratio * known),
            .spread = std::max(kSmallestSpread, std::sqrt(between + of_ratio)),
            .draw_cv = draw_cv,
            .common = std::sqrt(of_ratio)};
}

AuditedRatio with_further_audit(const AuditedRatio& all, const AuditedRatio& audit) {
    if (all.draws == 0 || !(all.predicted > 0.0)) return audit;
    const auto before = static_cast<double>(all.draws);
    const auto now = static_cast<double>(audit.draws);
    const double scale = audit.predicted / all.predicted;
    const double share = now / (before + now);
    return {
        .predicted = audit.predicted,
        .measured = share * audit.measured + (1.0 - share) * scale * all.measured,
        .variance = square(share) * audit.variance + square((1.0 - share) * scale) * all.variance,
        .draws = all.draws + audit.draws,
        .chance = audit.chance};
}

PooledError pooled_error(const ErrorPrior& prior, const AuditedRatio& audit, double confidence) {
    const double prior_shape = 2.0 + 1.0 / square(prior.spread);
    const double own_ratio =
        audit.predicted > 0.0 ? std::max(0.0, audit.measured) / audit.predicted : 0.0;
    // What an audit found is there, to the precision that its own draws show; of what it did not
    // find it knows as little as few draws of a heavy tail do.
    double own_shape = static_cast<double>(audit.draws) / square(prior.draw_cv);
    if (own_ratio > prior.ratio && audit.variance > 0.0) {
        own_shape = std::max(own_shape, square(audit.measured) / audit.variance);
    }
    const double shape = prior_shape + own_shape;
    const double scale = prior.ratio * (prior_shape - 1.0) + own_shape * own_ratio;
    const auto quantile = [&](double probability) {
        if (audit.chance > 0.0) {
            const boost::math::fisher_f_distribution<double> f(2.0 / square(audit.chance),
                                                               2.0 * shape);
            return audit.predicted * scale / shape * boost::math::quantile(f, probability);
        }
        const boost::math::gamma_distribution<double> gamma(shape);
        return audit.predicted * scale / boost::math::quantile(gamma, 1.0 - probability);
    };
    const double tail = kTailShare * (1.0 - confidence) / 2.0;
    return {.value = audit.predicted * scale / (shape - 1.0),
            .interval = {quantile(tail), quantile(1.0 - tail)},
            .upper = quantile(confidence),
            .spread = shape > 2.0 ? 1.0 / std::sqrt(shape - 2.0) : 1.0};
}

PooledError mean_error(std::span<const PooledError> probes, double common, double confidence) {
    double sum = 0.0;
    double variance = 0.0;
    for (const PooledError& probe : probes) {
        sum += probe.value;
        variance += square(probe.value * probe.spread);
    }
    if (!(sum > 0.0)) return {};
    const double spread = std::sqrt(variance / square(sum) + square(common));
    return pooled_error({.spread = std::max(kSmallestSpread / 10.0, spread)},
                        {.predicted = sum / static_cast<double>(probes.size())}, confidence);
}

}  // namespace probebake
