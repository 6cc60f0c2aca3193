// Water in the ground: rivers, whose level falls along a curve, and lakes.
#pragma once

#include "scene/generators/curve.h"
#include "scene/generators/noise.h"

namespace probebake::worldgen {

class River {
  public:
    struct Shape {
        std::vector<Vec2> through_m;
        double half_width_m = 4.0;
        double level_from_m = 45.0;  // height of the water at the first point
        double level_to_m = 40.0;    // and at the last
        double depth_m = 1.3;        // in the middle
    };
    River(const Shape& shape, uint64_t key);

    const Curve& curve() const { return curve_; }
    double level_m(double along) const {
        return mix(shape_.level_from_m, shape_.level_to_m, along);
    }
    /// Depth of the water; < 0 on the banks, far below 0 elsewhere.
    double depth_m(const Vec2& at_m) const;
    /// The ground `height_m` with the river cut into it; on the water, its surface.
    double cut(const Vec2& at_m, double height_m) const;

  private:
    double depth_at(const Curve::Nearest& nearest, const Vec2& at_m) const;

    Shape shape_;
    Curve curve_;
    Noise edge_;
};

class Lake {
  public:
    struct Shape {
        Vec2 center_m{0.0};
        Vec2 radii_m{40.0};
        double level_m = 40.0;
        double depth_m = 5.0;  // in the middle
    };
    Lake(const Shape& shape, uint64_t key) : shape_(shape), edge_(key) {}

    double level_m() const { return shape_.level_m; }
    /// Distance from the middle, 1 at the shore.
    double from_center(const Vec2& at_m) const;
    /// Depth of the water; < 0 on the banks and beyond.
    double depth_m(const Vec2& at_m) const;
    double cut(const Vec2& at_m, double height_m) const;

  private:
    Shape shape_;
    Noise edge_;
};

}  // namespace probebake::worldgen
