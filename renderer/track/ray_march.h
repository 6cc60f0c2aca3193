// Unbiased ray marching (Kettunen et al. 2021) of exp(−∫ μ dt): an oracle for tests, independent of
// majorants and free flights.
//
// Every X_i is an estimate of −τ from equidistant samples with one random offset; p, their mean, is
// the pivot. exp(−τ) = e^p E Σ_k ∏_{i ≤ k} (X_i − p) / k!, the sum truncated by the roulette of
// Bhanot and Kennedy, which goes on from term k − 1 to k > 2 with 0.9 / (k − 2). The pivot is made
// of samples of its own, which keeps the products unbiased.
//
// Deviation: Kettunen et al. make the pivot of the same samples and average over all their orders,
// which has less variance; an oracle needs the plain form only.
#pragma once

#include <cmath>

namespace probebake {

/// mu: double(double t); `samples` per estimate of −τ.
template <class Extinction, class Random>
double marched_transmittance(Extinction mu, double length, int samples, Random& random) {
    const auto estimate = [&] {
        const double step = length / samples;
        const double offset = random.uniform();
        double sum = 0.0;
        for (int i = 0; i < samples; ++i) sum -= mu((i + offset) * step);
        return sum * step;
    };
    const double pivot = estimate();
    constexpr double kContinue = 0.9;  // beyond the second order
    double term = 1.0;
    double sum = 1.0;
    for (int k = 1;; ++k) {
        if (k > 2) {
            if (!(random.uniform() < kContinue / (k - 2))) break;
            term *= (k - 2) / kContinue;
        }
        term *= (estimate() - pivot) / k;
        sum += term;
    }
    return std::exp(pivot) * sum;
}

}  // namespace probebake
