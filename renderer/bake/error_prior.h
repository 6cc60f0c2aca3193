// What a job knows of a probe's error before, and after, the probe's own audit.
//
// One small audit cannot tell one probe's error well; all audits of a job together tell well how
// its errors compare with what the renderer predicts. With P the prediction of a probe (mean
// squared error), its error is R · P, where over the probes of one job and state R has a mean and a
// relative spread: the prior. Its own audit of n draws, each with a relative standard deviation cv,
// says R = y. Both as gamma distributions (R inverse gamma; y of shape n / cv²), the posterior of R
// is inverse gamma again:
//
//   shape a + n / cv², scale b + (n / cv²) y,   a = 2 + 1 / spread², b = mean · (a − 1)
//
// never below zero and skewed to the right, as errors are. All audits of a probe count, those after
// which it was refined, too: a posterior, unlike an interval from the audit alone, means the same
// whatever made one stop looking (Rubin 1984, "Bayesianly justifiable and relevant frequency
// calculations", Ann. Statist. 12). This is the composite estimate of small
// areas (Fay and Herriot 1979, "Estimates of income for small places", J. Am. Statist. Assoc. 74)
// in a multiplicative form. docs/results/calibration.md measures that its intervals cover.
//
// Where audits tell what errors of pixels are to be expected to add up to, but not what they did,
// the error is R · P times a gamma distribution of mean 1 and that chance's spread: a multiple of
// an F distribution.
#pragma once

#include <cstdint>
#include <span>

#include "math/estimate.h"

namespace probebake {

/// Of actual over predicted mean squared error.
struct ErrorPrior {
    double ratio = 1.0;    // mean over the probes
    double spread = 1.0;   // relative standard deviation, what is not known of `ratio` included
    double draw_cv = 4.0;  // relative standard deviation of one audited pixel
    double common = 0.0;   // of the spread, what all probes of the job share
};

/// How far probes of a job differ, by the scenes of docs/results/calibration.md, until the job's
/// own audits tell.
inline constexpr double kUsualSpread = 0.7;
/// Where nothing tells: mean ratio, and relative standard deviation of an audited pixel, of squared
/// errors on those scenes.
inline constexpr ErrorPrior kUsualPrior = {.ratio = 0.65, .spread = kUsualSpread, .draw_cv = 10.0};

/// The same of squared irradiance errors over what unbiased noise leads to expect.
inline constexpr ErrorPrior kUsualIrradiancePrior = {.ratio = 1.0, .spread = 0.4, .draw_cv = 6.0};

/// Whether a sample of pixels tells a size that nothing else is known of. Beyond a relative
/// standard deviation of 0.7 a single one of them does.
bool tells(const Estimate& sampled);

/// An audit beside the renderer's prediction.
struct AuditedRatio {
    double predicted = 0.0;  // mean squared error
    double measured = 0.0;   // its estimate
    double variance = 0.0;   // of the estimate
    uint64_t draws = 0;
    /// Relative standard deviation of the error itself about what draws tell; 0: they tell of it.
    double chance = 0.0;
};

/// The prior that the audits of a job's first probes make of the one that its pilot made: ratios
/// count by their precision, the pilot's by `common` (0: it knew none, and does not count). Fewer
/// than two audits, or none that found anything, leave `before` as it is.
ErrorPrior learned_prior(const ErrorPrior& before, std::span<const AuditedRatio> audits);

/// `all` and a further audit of the same probe, as of what is predicted now.
AuditedRatio with_further_audit(const AuditedRatio& all, const AuditedRatio& audit);

/// Mean, two-sided interval and one-sided upper bound of the mean squared error.
struct PooledError {
    double value = 0.0;
    Interval interval;
    double upper = 0.0;
    double spread = 0.0;  // relative standard deviation
};
PooledError pooled_error(const ErrorPrior& prior, const AuditedRatio& audit, double confidence);

/// The mean over probes whose errors have `common`, a relative standard deviation, in common and
/// are else independent.
PooledError mean_error(std::span<const PooledError> probes, double common, double confidence);

}  // namespace probebake
