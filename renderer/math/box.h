// What building trees over boxes needs of them: joining, growing, overlap of closed boxes.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "math/affine.h"

namespace probebake {

/// Joined with any box it is that box.
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline Box empty_box() { return {Vec3(kInfinity), Vec3(-kInfinity)}; }

inline Box join(const Box& a, const Box& b) {
    return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}
inline Box join(const Box& box, const Vec3& point) { return join(box, Box{point, point}); }

inline Box grown(const Box& box, double margin) {
    return {box.low - Vec3(margin), box.high + Vec3(margin)};
}

/// Also where they only touch.
inline bool overlap_closed(const Box& a, const Box& b) {
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y &&
           b.low.y <= a.high.y && a.low.z <= b.high.z && b.low.z <= a.high.z;
}

/// The largest absolute coordinate: what rounding is measured by.
inline double scale_of(const Box& box) {
    const Vec3 most = glm::max(glm::abs(box.low), glm::abs(box.high));
    return std::max({most.x, most.y, most.z});
}

}  // namespace probebake
