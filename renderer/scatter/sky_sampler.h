// Directions towards the sky drawn by its radiance, for next-event estimation.
//
// A picture is cut into equirectangular cells in world directions, at most kMostColumns wide, each
// weighed by the mean of its texels and channels; within a cell directions are uniform
// in solid angle. The density is positive wherever the sky is, so that with it alone, or weighed
// against another density, estimates are unbiased. Smooth skies (none, constant, gradient) have no
// sampler: scattering finds them as well.
#pragma once

#include <vector>

#include "light/sky.h"

namespace probebake {

class SkySampler {
  public:
    static constexpr int kMostColumns = 1024;

    explicit SkySampler(const Sky& sky);

    /// Whether the sky is worth sampling.
    bool empty() const { return total_ <= 0.0; }

    struct Sample {
        Vec3 direction{0.0, 1.0, 0.0};
        double pdf = 0.0;  // per sr
    };
    /// u, v in [0, 1).
    Sample sample(double u, double v) const;
    double pdf(const Vec3& direction) const;

  private:
    double cell_weight(int row, int column) const;
    double cell_pdf(int row, int column) const;
    double row_solid_angle(int row) const;

    int columns_ = 0;
    int rows_ = 0;
    double total_ = 0.0;
    std::vector<double> row_sums_;   // cumulative over the rows above and this one
    std::vector<float> weights_;     // per cell, times its solid angle
    std::vector<float> cumulative_;  // along a row
};

}  // namespace probebake
