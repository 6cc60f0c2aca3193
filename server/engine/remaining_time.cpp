#include "engine/remaining_time.h"

#include <algorithm>
#include <array>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <random>

namespace probebake {
namespace {

constexpr size_t kDraws = 200;
constexpr size_t kFirstDraws = 20;  // not yet of the distribution
constexpr size_t kOutside = 5;      // draws beyond each end of the interval: 2.5 %
/// What is thought of the spread counts as much as so many units.
constexpr double kPriorUnits = 3.0;
/// The next of k + 1 units is the dearest with probability 1/(k+1): half as often, of a hundred
/// units one at most, for a reason of its own, by a Pareto distributed factor whose logarithm has
/// this share of the spread for its mean.
constexpr double kBeyondShare = 0.5;
constexpr double kMostBeyond = 0.01;
constexpr double kExcessShare = 0.75;
/// No job's probes differ more: a standard deviation of a factor of 12.
constexpr double kMostSpread = 2.5;
/// Machines are not as fast at one time as at another: as a logarithm.
constexpr double kMachineSpread = 0.1;
/// A unit that just began has taken no less than this.
constexpr double kLeastSeconds = 1e-6;

double seconds_between(UnitTimes::TimePoint from, UnitTimes::TimePoint to) {
    return std::chrono::duration<double>(to - from).count();
}

using Random = std::mt19937_64;

/// Of a normal distribution, what lies above `least`.
double draw_above(double least, double mean, double deviation, Random& random) {
    const double z = (least - mean) / deviation;
    const double u = 1.0 - std::uniform_real_distribution()(random);  // not 0
    if (z > 6.0) return least - deviation * std::log(u) / z;          // the tail falls as exp(-z x)
    return mean +
           deviation * std::sqrt(2.0) * boost::math::erfc_inv(u * std::erfc(z / std::sqrt(2.0)));
}

/// The logarithm of the sum of `count` lognormal values of these parameters.
double draw_log_of_sum(double mean, double deviation, double count, Random& random) {
    const double variance = std::log1p(std::expm1(deviation * deviation) / count);
    const double log_of_mean = mean + deviation * deviation / 2.0 + std::log(count);
    return std::normal_distribution(log_of_mean - variance / 2.0, std::sqrt(variance))(random);
}

}  // namespace

void UnitTimes::start(TimePoint begin, uint64_t units, double pixels, double spread) {
    *this = {};
    begin_ = begin;
    waiting_ = units;
    waiting_pixels_ = pixels;
    spread_ = spread;
}

void UnitTimes::begin_unit(uint64_t unit, double pixels, TimePoint now) {
    --waiting_;
    waiting_pixels_ -= pixels;
    running_.push_back({unit, pixels, now});
}

void UnitTimes::end_unit(uint64_t unit, TimePoint now, bool done) {
    const auto at = std::find_if(running_.begin(), running_.end(),
                                 [&](const Running& running) { return running.unit == unit; });
    const double seconds = std::max(kLeastSeconds, seconds_between(at->begin, now));
    done_seconds_ += seconds;
    if (done) {
        log_per_pixel_.add(std::log(seconds / at->pixels));
        most_log_per_pixel_ = std::max(most_log_per_pixel_, std::log(seconds / at->pixels));
    }
    running_.erase(at);
}

double UnitTimes::concurrency(TimePoint now) const {
    double seconds = done_seconds_;
    for (const Running& unit : running_) seconds += seconds_between(unit.begin, now);
    return std::max(1.0, seconds / std::max(kLeastSeconds, seconds_between(begin_, now)));
}

std::optional<RemainingTime> UnitTimes::left(TimePoint now) const {
    if (log_per_pixel_.count() == 0) return {};
    if (waiting_ == 0 && running_.empty()) return RemainingTime{};
    Random random(log_per_pixel_.count());
    std::normal_distribution normal;
    std::exponential_distribution excess(1.0 / (kExcessShare * spread_));
    const auto known = static_cast<double>(log_per_pixel_.count());
    const double at_a_time = concurrency(now);
    double mean = log_per_pixel_.mean();
    double deviation = spread_;
    std::array<double, kDraws> draws{};
    for (size_t i = 0; i < kFirstDraws + kDraws; ++i) {
        double left = 0.0;
        double sum = known * log_per_pixel_.mean();
        double squares = known * log_per_pixel_.mean() * log_per_pixel_.mean() +
                         std::max(0.0, known - 1.0) * log_per_pixel_.variance();
        for (const Running& unit : running_) {
            const double so_far = std::max(kLeastSeconds, seconds_between(unit.begin, now));
            const double least = std::log(so_far / unit.pixels);
            const double log_cost = draw_above(least, mean, deviation, random);
            sum += log_cost;
            squares += log_cost * log_cost;
            left += std::exp(log_cost) * unit.pixels - so_far;
        }
        const double count = known + static_cast<double>(running_.size());
        const double deviations = std::max(0.0, squares - sum * sum / count);
        // Scaled inverse chi-squared of the variance, normal of the mean (Gelman et al. 2013, 3.2).
        std::chi_squared_distribution chi(kPriorUnits + count - 1.0);
        const double variance =
            (kPriorUnits * spread_ * spread_ + deviations) / std::max(1e-9, chi(random));
        deviation = std::min(kMostSpread, std::sqrt(variance));
        mean = sum / count + deviation / std::sqrt(count) * normal(random);
        if (waiting_ > 0) {
            const auto units = static_cast<double>(waiting_);
            left +=
                std::exp(draw_log_of_sum(mean, deviation, units, random)) * waiting_pixels_ / units;
            std::poisson_distribution<int> beyond(
                units * std::min(kMostBeyond, kBeyondShare / (known + 1.0)));
            for (int dear = beyond(random); dear > 0; --dear) {
                left += std::exp(most_log_per_pixel_ + excess(random)) * waiting_pixels_ / units;
            }
        }
        if (i < kFirstDraws) continue;
        draws[i - kFirstDraws] = left / at_a_time * std::exp(kMachineSpread * normal(random));
    }
    std::sort(draws.begin(), draws.end());
    return RemainingTime{draws[kDraws / 2], {draws[kOutside], draws[kDraws - 1 - kOutside]}};
}

}  // namespace probebake
