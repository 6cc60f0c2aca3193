// The length of an unknown vector, from an unbiased estimate of it with a known covariance.
//
// x is the vector, y = x + e what was measured, e normal with mean 0 and covariance S. With
// Q = |y|², T = tr S, F = tr S² and λ the largest eigenvalue of S:
//
//   E[Q] = |x|² + T        var[Q] = 2 F + 4 xᵀS x ≤ 2 F + 4 λ |x|²
//
// so that Q − T estimates |x|² without bias, and the ends of the interval are the |x|² = X at which
// what was seen would be z standard deviations off: Q − T − X = ∓z √(2F + 4λX), that is
// X = b + 2z²λ ± √(4z²λ b + 4z⁴λ² + 2z²F) with b = Q − T. The upper end takes max(b, 0): a Q by
// chance below T must not promise more than Q = T does. Towards low Q a sum of squares has a
// shorter tail than the normal distribution, so that the upper end is on the safe side; towards
// high Q it has a longer one, and z is that of the chi-squared distribution with the same two
// moments (Satterthwaite 1946). No norm of a difference hides here: |y| + |e| bounds |x| as well
// (triangle inequality), but is 1.5 to 2 times as wide where noise prevails.
#pragma once

#include <span>
#include <vector>

#include "math/estimate.h"

namespace probebake {

struct NormEstimate {
    double squared = 0.0;    // Q
    double variance = 0.0;   // T
    double variance2 = 0.0;  // F
    double largest = 0.0;    // λ, or a little more
    uint64_t samples = 0;
    double degrees_of_freedom = 0.0;
    /// Where nothing is found: |x| if all samples differed as much as they may, and how many draws
    /// would have told of one that does. 0: not known.
    double longest = 0.0;
    uint64_t told = 0;

    /// Of |x|: the root of the unbiased estimate of its square, 0 where that is negative.
    double value() const;
    /// Two-sided interval of |x|; [0, infinity] below two samples. Where nothing was found, up to
    /// what may lie unseen: unseen_share(told) · longest.
    Interval interval(double confidence) const;
    /// No sample differed from 0.
    bool nothing_found() const { return samples > 0 && squared == 0.0 && variance == 0.0; }

    /// Of factor · x.
    NormEstimate scaled(double factor) const;
    /// Adds weight · |part|², independent of what is in already: √Σ weight |x|² is the length of
    /// all the vectors put together.
    void add(double weight, const NormEstimate& part);
};

/// The mean of vectors that were drawn independently, and its covariance.
class VectorMean {
  public:
    /// samples: one vector of `dimensions` after the other; at least two.
    VectorMean(std::span<const double> samples, size_t dimensions);

    std::span<const double> mean() const { return mean_; }
    /// Of one coordinate of the mean.
    double standard_error(size_t i) const;
    /// Of the expected vector, each coordinate multiplied by its factor.
    NormEstimate norm(std::span<const double> factors) const;

  private:
    uint64_t count_ = 0;
    std::vector<double> mean_;
    std::vector<double> covariance_;  // of the mean; row by row
};

}  // namespace probebake
