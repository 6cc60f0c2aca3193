#include "engine/remaining_time.h"

#include <algorithm>
#include <cmath>

namespace probebake {
namespace {

constexpr double kConfidence = 0.95;
/// Machines are not as fast at one time as at another.
constexpr double kMachineShare = 0.15;
constexpr double kFirstGuess = 3.0;

}  // namespace

void UnitTimes::add(double seconds, double pixels) {
    per_pixel_.add(seconds / pixels);
    pixels_ += pixels;
}

RemainingTime UnitTimes::left(double elapsed_seconds, double units, double pixels) const {
    if (!(units > 0.0)) return {};
    const double seconds = elapsed_seconds * pixels / pixels_;
    const auto k = static_cast<double>(per_pixel_.count());
    if (k < 2.0) return {seconds, {seconds / kFirstGuess, seconds * kFirstGuess}};
    const double relative = std::sqrt(per_pixel_.variance()) / per_pixel_.mean();
    const double of_units = relative * std::sqrt(1.0 / units + 1.0 / k) *
                            student_t_quantile(0.5 + kConfidence / 2.0, k - 1.0);
    const double share = std::hypot(of_units, kMachineShare);
    return {seconds, {seconds * std::max(0.0, 1.0 - share), seconds * (1.0 + share)}};
}

}  // namespace probebake
