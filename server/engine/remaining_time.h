// How much longer a bake will take, from the units that are done: with an interval.
//
// A unit's seconds per pixel vary from probe to probe; with s their standard deviation, the time of
// the R units that are left is known to within s · √(R + R²/k) after k of them (what they will take
// themselves, and what is not known of their mean), times a quantile of Student's t, and to within
// a share for the machine's sake. Before two units are done the interval is three times as long and
// a third as short.
#pragma once

#include <cstdint>

#include "math/estimate.h"

namespace probebake {

struct RemainingTime {
    double seconds = 0.0;
    Interval interval;  // 95 %
};

class UnitTimes {
  public:
    /// A unit of so many pixels took `seconds` of wall time, others beside it.
    void add(double seconds, double pixels);

    /// For `units` of `pixels` together. `elapsed_seconds`: of wall time, in which the units so far
    /// were done. At least one unit has been added.
    RemainingTime left(double elapsed_seconds, double units, double pixels) const;

  private:
    Moments per_pixel_;
    double pixels_ = 0.0;
};

}  // namespace probebake
