#include "scene/generators/ground.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace probebake::worldgen {

Ground::Ground(int size, double voxel_m, const std::function<double(const Vec2&)>& height_m)
    : size_(size), voxel_m_(voxel_m) {
    const auto stride = static_cast<size_t>(size) + 2;
    heights_m_.resize(stride * stride);
    tbb::parallel_for(0, size + 2, [&](int row) {
        float* out = heights_m_.data() + static_cast<size_t>(row) * stride;
        for (int column = 0; column < size + 2; ++column) {
            const Vec2 at_m = Vec2(column - 0.5, row - 0.5) * voxel_m;
            out[column] = static_cast<float>(height_m(at_m));
        }
    });
}

double Ground::height_m(int x, int z) const {
    const auto stride = static_cast<size_t>(size_) + 2;
    const auto column = static_cast<size_t>(std::clamp(x, -1, size_) + 1);
    const auto row = static_cast<size_t>(std::clamp(z, -1, size_) + 1);
    return heights_m_[row * stride + column];
}

double Ground::height_m(const Vec2& at_m) const {
    const Vec2 p = at_m / voxel_m_ - 0.5;
    const int x = static_cast<int>(std::floor(p.x));
    const int z = static_cast<int>(std::floor(p.y));
    const Vec2 f = p - glm::floor(p);
    const double near = height_m(x, z) * (1.0 - f.x) + height_m(x + 1, z) * f.x;
    const double far = height_m(x, z + 1) * (1.0 - f.x) + height_m(x + 1, z + 1) * f.x;
    return near * (1.0 - f.y) + far * f.y;
}

int Ground::top(int x, int z) const {
    return std::clamp(static_cast<int>(std::floor(height_m(x, z) / voxel_m_)), 0, size_ - 1);
}

int Ground::bottom(int x, int z) const {
    return std::min({top(x, z), top(x - 1, z), top(x + 1, z), top(x, z - 1), top(x, z + 1)});
}

double Ground::slope(int x, int z) const {
    const int reach = std::max(1, static_cast<int>(std::lround(1.0 / voxel_m_)));
    const double dx = height_m(x + reach, z) - height_m(x - reach, z);
    const double dz = height_m(x, z + reach) - height_m(x, z - reach);
    return std::sqrt(dx * dx + dz * dz) / (2.0 * reach * voxel_m_);
}

double Ground::relief_m(int x, int z) const {
    const int reach = std::max(1, static_cast<int>(std::lround(4.0 / voxel_m_)));
    const double mean = 0.25 * (height_m(x + reach, z) + height_m(x - reach, z) +
                                height_m(x, z + reach) + height_m(x, z - reach));
    return height_m(x, z) - mean;
}

}  // namespace probebake::worldgen
