// The ground of a landscape as one height per column of voxels, and the shell of voxels around it.
//
// A column reaches from its top voxel down to the top of its lowest neighbour of four, so that the
// ground is closed: no ray from above gets below it. Metres and voxels share their origin; column
// (x, z) is sampled at its centre, and columns exist for −1 ≤ x, z ≤ size.
#pragma once

#include <functional>
#include <vector>

#include "math/vec.h"

namespace probebake::worldgen {

class Ground {
  public:
    /// Samples `height_m` at every column, in parallel on the calling arena.
    Ground(int size, double voxel_m, const std::function<double(const Vec2&)>& height_m);

    int size() const { return size_; }
    double voxel_m() const { return voxel_m_; }
    /// Height of a column; coordinates outside are clamped.
    double height_m(int x, int z) const;
    /// Height between the columns, bilinear.
    double height_m(const Vec2& at_m) const;
    /// y of the topmost voxel of a column.
    int top(int x, int z) const;
    /// y of the lowest voxel that is part of the shell.
    int bottom(int x, int z) const;
    /// Rise over run, over about two metres, so that single voxels do not show in it.
    double slope(int x, int z) const;
    /// Height above the mean of four columns some metres away: > 0 on crests, < 0 in hollows.
    double relief_m(int x, int z) const;

  private:
    int size_;
    double voxel_m_;
    std::vector<float> heights_m_;
};

}  // namespace probebake::worldgen
