// Means estimated from samples, with confidence intervals that respect skewness.
//
// Squared errors of pixels are strongly skewed: most are nearly 0, a few are large. The ordinary t
// interval is then too low at its upper end. Hall (1992, "On the removal of skewness by
// transformation", J. R. Statist. Soc. B 54) transforms the studentised mean by a monotone cubic
// that removes its skewness; with g the skewness of the estimate,
//
//   f(T) = T + g T²/3 + g² T³/27 + g/6,      f⁻¹(z) = (3/g) · (cbrt(1 + g (z − g/6)) − 1)
//
// and the interval is [mean − s f⁻¹(z_hi), mean − s f⁻¹(z_lo)] with s the standard error.
#pragma once

#include <cstdint>

namespace probebake {

/// Count, mean and central moments of samples, updated one by one (Pébay 2008).
class Moments {
  public:
    void add(double x);

    uint64_t count() const { return count_; }
    double mean() const { return mean_; }
    /// Unbiased variance of a sample; 0 below two samples.
    double variance() const;
    /// Third central moment of a sample.
    double third_moment() const;

  private:
    uint64_t count_ = 0;
    double mean_ = 0.0;
    double m2_ = 0.0;
    double m3_ = 0.0;
};

struct Interval {
    double low = 0.0;
    double high = 0.0;
};

/// An estimate of a mean: from one sample, or the weighted sum of independent estimates.
struct Estimate {
    double value = 0.0;
    double variance = 0.0;      // of `value`
    double third_moment = 0.0;  // central, of `value`
    uint64_t samples = 0;
    double degrees_of_freedom = 0.0;
    /// Of what cannot be below 0, where nothing is found: what a sample may be at most, and how
    /// many draws would have told of it. 0: not known.
    double largest = 0.0;
    uint64_t told = 0;

    /// The mean of a sample.
    static Estimate of_mean(const Moments& moments);
    /// Adds weight × part, independent of what is in already (Welch-Satterthwaite for the degrees
    /// of freedom).
    void add(double weight, const Estimate& part);

    double standard_error() const;
    /// Every sample was exactly 0: nothing was found, which does not say that nothing is there.
    bool nothing_found() const { return samples > 0 && value == 0.0 && variance == 0.0; }
    /// Two-sided interval; infinite on both sides below two samples. Where nothing was found
    /// above 0, up to what may lie unseen: unseen_share(told) · largest.
    Interval interval(double confidence) const;
};

/// Largest share of a population that may differ when none of n independent draws did, at this
/// confidence (Clopper and Pearson 1934): 0.049 for n = 59 and 0.95.
double unseen_share(uint64_t samples, double confidence);

/// Quantile of Student's t distribution.
double student_t_quantile(double probability, double degrees_of_freedom);

}  // namespace probebake
