// How much longer a bake will take, from the units that are done and those under way: with an
// interval.
//
// Seconds per pixel are lognormal from unit to unit: alike where rays end on voxels, hundreds of
// times as much within a cloud as beside it. Units that are under way have taken so much, and will
// take more; left out, they would make the dear ones, which are under way the longest, seem rarer
// than they are. Gibbs sampling (Tanner and Wong 1987, "The calculation of posterior distributions
// by data augmentation", J. Am. Stat. Assoc. 82) draws what they will have taken, then mean and
// spread of the logarithms, in turn; every draw tells the sum of what is left (moments of a sum of
// lognormals after Fenton 1960), with some units that are dearer than any so far, as the probe in
// the midst of the cloud is; and the draws' quantiles are the interval. The same units at the same
// times tell the same.
#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "math/estimate.h"

namespace probebake {

struct RemainingTime {
    double seconds = 0.0;  // the median
    Interval interval;     // 95 %
};

class UnitTimes {
  public:
    using TimePoint = std::chrono::steady_clock::time_point;

    /// Units of so many pixels in all are baked from `begin` on. `spread`: what the standard
    /// deviation of the logarithm of seconds per pixel is thought to be before any is known.
    void start(TimePoint begin, uint64_t units, double pixels, double spread);
    void begin_unit(uint64_t unit, double pixels, TimePoint now);
    /// It is done, or was given up (and tells nothing then).
    void end_unit(uint64_t unit, TimePoint now, bool done);

    /// No value before the first unit is done.
    std::optional<RemainingTime> left(TimePoint now) const;

  private:
    struct Running {
        uint64_t unit = 0;
        double pixels = 0.0;
        TimePoint begin;
    };

    /// Units that take their turns at a time, on the average until now.
    double concurrency(TimePoint now) const;

    TimePoint begin_;
    double spread_ = 0.0;
    Moments log_per_pixel_;
    double most_log_per_pixel_ = std::numeric_limits<double>::lowest();
    double done_seconds_ = 0.0;
    uint64_t waiting_ = 0;
    double waiting_pixels_ = 0.0;
    std::vector<Running> running_;
};

}  // namespace probebake
