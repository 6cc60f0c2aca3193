// Coarse fields over the world of a landscape and a margin around it.
//
// Positions are metres on the ground plane, (x, z); the world is [0, kWorldSide_m)².
#pragma once

#include <functional>
#include <vector>

#include "math/vec.h"

namespace probebake::worldgen {

/// Side of the world of every landscape, in metres, whatever its size in voxels.
inline constexpr double kWorldSide_m = 512.0;
inline constexpr double kGridMargin_m = 64.0;

/// A square grid of values over the world and its margin.
class Grid {
  public:
    explicit Grid(int side, double fill = 0.0);
    /// Values of `f` at the cells' centres; parallel on the calling arena.
    Grid(int side, const std::function<double(const Vec2&)>& f);

    int side() const { return side_; }
    double cell_m() const { return (kWorldSide_m + 2.0 * kGridMargin_m) / side_; }
    Vec2 center_m(int x, int z) const {
        return {(x + 0.5) * cell_m() - kGridMargin_m, (z + 0.5) * cell_m() - kGridMargin_m};
    }
    double& operator()(int x, int z) { return values_[index(x, z)]; }
    double operator()(int x, int z) const { return values_[index(x, z)]; }
    std::vector<double>& values() { return values_; }
    const std::vector<double>& values() const { return values_; }
    /// Catmull-Rom between the centres; the border's value outside.
    double sample(const Vec2& at_m) const;
    /// The value of the cell that holds the point (outside: of the border cell).
    double nearest_value(const Vec2& at_m) const;

  private:
    size_t index(int x, int z) const {
        return static_cast<size_t>(z) * static_cast<size_t>(side_) + static_cast<size_t>(x);
    }

    int side_;
    std::vector<double> values_;
};

}  // namespace probebake::worldgen
