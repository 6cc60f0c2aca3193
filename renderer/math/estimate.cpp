#include "math/estimate.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace probebake {

void Moments::add(double x) {
    const auto n1 = static_cast<double>(count_);
    ++count_;
    const auto n = static_cast<double>(count_);
    const double delta = x - mean_;
    const double delta_n = delta / n;
    const double term = delta * delta_n * n1;
    mean_ += delta_n;
    m3_ += term * delta_n * (n - 2.0) - 3.0 * delta_n * m2_;
    m2_ += term;
}

double Moments::variance() const {
    return count_ < 2 ? 0.0 : m2_ / static_cast<double>(count_ - 1);
}

double Moments::third_moment() const {
    return count_ == 0 ? 0.0 : m3_ / static_cast<double>(count_);
}

Estimate Estimate::of_mean(const Moments& moments) {
    const auto n = static_cast<double>(moments.count());
    if (moments.count() == 0) return {};
    return {.value = moments.mean(),
            .variance = moments.variance() / n,
            .third_moment = moments.third_moment() / (n * n),
            .samples = moments.count(),
            .degrees_of_freedom = n - 1.0};
}

void Estimate::add(double weight, const Estimate& part) {
    const auto share = [](double v, double dof) { return dof > 0.0 ? v * v / dof : 0.0; };
    const double added = weight * weight * part.variance;
    const double spread =
        share(variance, degrees_of_freedom) + share(added, part.degrees_of_freedom);
    value += weight * part.value;
    variance += added;
    third_moment += weight * weight * weight * part.third_moment;
    samples += part.samples;
    largest = std::max(largest, part.largest);
    told += part.told;
    degrees_of_freedom =
        spread > 0.0 ? variance * variance / spread : degrees_of_freedom + part.degrees_of_freedom;
}

double Estimate::standard_error() const { return std::sqrt(variance); }

Interval Estimate::interval(double confidence) const {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (!(degrees_of_freedom > 0.0)) return {-kInfinity, kInfinity};
    const double s = standard_error();
    const double unseen = largest > 0.0 ? largest * unseen_share(told, confidence) : 0.0;
    if (!(s > 0.0)) return {value, nothing_found() ? unseen : value};
    const double z = student_t_quantile(0.5 + confidence / 2.0, degrees_of_freedom);
    const double g = third_moment / (s * s * s);
    const auto inverse = [g](double x) {
        if (std::abs(g) < 1e-6) return x;
        return 3.0 / g * (std::cbrt(1.0 + g * (x - g / 6.0)) - 1.0);
    };
    const double high = value - s * inverse(-z);
    return {value - s * inverse(z), largest > 0.0 && high <= 0.0 ? unseen : high};
}

double unseen_share(uint64_t samples, double confidence) {
    return 1.0 - std::pow(1.0 - confidence, 1.0 / static_cast<double>(samples));
}

double student_t_quantile(double probability, double degrees_of_freedom) {
    return boost::math::quantile(boost::math::students_t(degrees_of_freedom), probability);
}

}  // namespace probebake
