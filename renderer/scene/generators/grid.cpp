#include "scene/generators/grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace probebake::worldgen {

Grid::Grid(int side, double fill)
    : side_(side), values_(static_cast<size_t>(side) * static_cast<size_t>(side), fill) {}

Grid::Grid(int side, const std::function<double(const Vec2&)>& f) : Grid(side) {
    tbb::parallel_for(0, side, [&](int z) {
        for (int x = 0; x < side; ++x) (*this)(x, z) = f(center_m(x, z));
    });
}

double Grid::sample(const Vec2& at_m) const {
    const double gx = (at_m.x + kGridMargin_m) / cell_m() - 0.5;
    const double gz = (at_m.y + kGridMargin_m) / cell_m() - 0.5;
    const auto weights = [](double t) {
        return std::array<double, 4>{
            0.5 * t * (-1.0 + t * (2.0 - t)), 0.5 * (2.0 + t * t * (3.0 * t - 5.0)),
            0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), 0.5 * t * t * (t - 1.0)};
    };
    const auto wx = weights(gx - std::floor(gx));
    const auto wz = weights(gz - std::floor(gz));
    const int x0 = static_cast<int>(std::floor(gx)) - 1;
    const int z0 = static_cast<int>(std::floor(gz)) - 1;
    double sum = 0.0;
    for (int j = 0; j < 4; ++j) {
        const int z = std::clamp(z0 + j, 0, side_ - 1);
        double row = 0.0;
        for (int i = 0; i < 4; ++i) {
            row += wx[static_cast<size_t>(i)] * (*this)(std::clamp(x0 + i, 0, side_ - 1), z);
        }
        sum += wz[static_cast<size_t>(j)] * row;
    }
    return sum;
}

double Grid::nearest_value(const Vec2& at_m) const {
    const auto cell = [this](double m) {
        return std::clamp(static_cast<int>(std::floor((m + kGridMargin_m) / cell_m())), 0,
                          side_ - 1);
    };
    return (*this)(cell(at_m.x), cell(at_m.y));
}

}  // namespace probebake::worldgen
