// A ray as the primitive tests want it: unit direction, beginning at or in the scene's box.
//
// From an origin a million boxes away every t would carry an error of 1e-10 of a box; a direction
// of length 1e-6 or 1e6 would move the tests' thresholds. So the ray is brought to where it enters
// the box, and scaled; t goes back at the end.
#pragma once

#include <optional>

#include "math/box.h"

namespace probebake {

struct LocalRay {
    Ray ray;       // unit direction
    TRange range;  // what is asked for, in the local t
    double t_entry = 0.0;
    double unit = 1.0;  // local t per t of the ray that was given

    double t_given(double t_local) const { return (t_local + t_entry) / unit; }
};

/// None where the ray misses the box, has no direction or is not finite. Hits are asked for with
/// range.begin < t < range.end.
std::optional<LocalRay> local_ray(const Box& box, const Ray& ray, const TRange& range);

}  // namespace probebake
