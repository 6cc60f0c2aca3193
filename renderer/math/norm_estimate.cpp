#include "math/norm_estimate.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>

namespace probebake {
namespace {

/// Standard deviations above its mean that a sum of squares with trace T and T² / F degrees of
/// freedom exceeds with this probability.
double upper_quantile(double probability, double trace, double trace2) {
    const double dof = trace * trace / trace2;
    const double quantile = boost::math::quantile(boost::math::chi_squared(dof), probability);
    return (quantile - dof) / std::sqrt(2.0 * dof);
}

/// The square of a symmetric matrix.
std::vector<double> squared(const std::vector<double>& matrix, size_t n) {
    std::vector<double> product(n * n, 0.0);
    for (size_t i = 0; i < n; ++i) {
        for (size_t k = 0; k < n; ++k) {
            const double left = matrix[i * n + k];
            for (size_t j = 0; j < n; ++j) product[i * n + j] += left * matrix[k * n + j];
        }
    }
    return product;
}

double sum_of_squares(std::span<const double> values) {
    double sum = 0.0;
    for (const double value : values) sum += value * value;
    return sum;
}

/// At least the largest eigenvalue of a covariance: (tr S¹⁶)^(1/16), too large by the 16th root of
/// the dimension at most.
double largest_eigenvalue(std::vector<double> matrix, size_t n, double trace) {
    if (!(trace > 0.0)) return 0.0;
    for (double& value : matrix) value /= trace;  // so that powers stay in range
    for (int power = 1; power < 8; power *= 2) matrix = squared(matrix, n);
    return trace * std::pow(sum_of_squares(matrix), 1.0 / 16.0);
}

}  // namespace

double NormEstimate::value() const { return std::sqrt(std::max(0.0, squared - variance)); }

Interval NormEstimate::interval(double confidence) const {
    if (!(degrees_of_freedom > 0.0)) return {0.0, std::numeric_limits<double>::infinity()};
    if (nothing_found() && longest > 0.0) return {0.0, longest * unseen_share(told, confidence)};
    if (!(variance > 0.0)) return {std::sqrt(squared), std::sqrt(squared)};
    const double probability = 0.5 + confidence / 2.0;
    const double z = student_t_quantile(probability, degrees_of_freedom);
    const auto root = [&](double b, double at, double sign) {
        const double at2 = at * at;
        const double inside =
            4.0 * at2 * largest * b + 4.0 * at2 * at2 * largest * largest + 2.0 * at2 * variance2;
        const double x = b + 2.0 * at2 * largest + sign * std::sqrt(std::max(0.0, inside));
        return std::sqrt(std::max(0.0, x));
    };
    const double b = squared - variance;
    const double high = root(std::max(b, 0.0), z, 1.0);
    if (!(b > 0.0)) return {0.0, high};
    const double longer_tail = std::max(z, upper_quantile(probability, variance, variance2));
    // Where even x = 0 would not have been surprising, the smaller root is no solution.
    const bool zero_is_possible = b <= longer_tail * std::sqrt(2.0 * variance2);
    return {zero_is_possible ? 0.0 : root(b, longer_tail, -1.0), high};
}

NormEstimate NormEstimate::scaled(double factor) const {
    const double square = factor * factor;
    NormEstimate out = *this;
    out.squared *= square;
    out.variance *= square;
    out.variance2 *= square * square;
    out.largest *= square;
    out.longest *= factor;
    return out;
}

void NormEstimate::add(double weight, const NormEstimate& part) {
    squared += weight * part.squared;
    variance += weight * part.variance;
    variance2 += weight * weight * part.variance2;
    largest = std::max(largest, weight * part.largest);
    samples += part.samples;
    longest = std::max(longest, part.longest);
    told += part.told;
    degrees_of_freedom += part.degrees_of_freedom;
}

VectorMean::VectorMean(std::span<const double> samples, size_t dimensions)
    : count_(samples.size() / dimensions),
      mean_(dimensions, 0.0),
      covariance_(dimensions * dimensions, 0.0) {
    const auto n = static_cast<double>(count_);
    for (size_t s = 0; s < count_; ++s) {
        for (size_t i = 0; i < dimensions; ++i) mean_[i] += samples[s * dimensions + i] / n;
    }
    std::vector<double> off(dimensions);
    for (size_t s = 0; s < count_; ++s) {
        for (size_t i = 0; i < dimensions; ++i) off[i] = samples[s * dimensions + i] - mean_[i];
        for (size_t i = 0; i < dimensions; ++i) {
            for (size_t j = 0; j < dimensions; ++j) {
                covariance_[i * dimensions + j] += off[i] * off[j];
            }
        }
    }
    for (double& value : covariance_) value /= n * (n - 1.0);
}

double VectorMean::standard_error(size_t i) const {
    return std::sqrt(covariance_[i * mean_.size() + i]);
}

NormEstimate VectorMean::norm(std::span<const double> factors) const {
    const size_t n = mean_.size();
    std::vector<double> matrix = covariance_;
    NormEstimate out{.samples = count_, .degrees_of_freedom = static_cast<double>(count_) - 1.0};
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; j < n; ++j) matrix[i * n + j] *= factors[i] * factors[j];
        out.squared += mean_[i] * mean_[i] * factors[i] * factors[i];
        out.variance += matrix[i * n + i];
    }
    out.variance2 = sum_of_squares(matrix);
    out.largest = largest_eigenvalue(std::move(matrix), n, out.variance);
    return out;
}

}  // namespace probebake
