// Smooth lines on the map: rivers, valleys, paths.
#pragma once

#include <cstdint>
#include <vector>

#include "math/vec.h"
#include "scene/generators/grid.h"

namespace probebake::worldgen {

/// The points, each moved by up to `reach_m` along both axes.
std::vector<Vec2> jittered(std::vector<Vec2> points_m, const Vec2& reach_m, uint64_t key);

class Curve {
  public:
    /// Through at least two points, smoothly (Catmull-Rom).
    explicit Curve(const std::vector<Vec2>& through_m);

    struct Nearest {
        double distance_m;
        double along;  // 0 at the first point, 1 at the last, by length
    };
    /// Exact where the curve is closer than `reach_m`; a distance of at least that elsewhere.
    Nearest nearest(const Vec2& at_m, double reach_m) const;
    Vec2 at(double along) const;
    double length_m() const { return begins_m_.back(); }

  private:
    std::vector<Vec2> points_m_;
    std::vector<double> begins_m_;  // length of the curve before each point
    Grid rough_distance_m_;         // keeps far queries cheap
};

}  // namespace probebake::worldgen
