#include "scene/generators/river.h"

#include <algorithm>
#include <cmath>

namespace probebake::worldgen {
namespace {

constexpr double kFarAway_m = -100.0;
constexpr double kBankWidths = 3.0;  // how far the banks reach, in half widths

}  // namespace

River::River(const Shape& shape, uint64_t key)
    : shape_(shape), curve_(shape.through_m), edge_(key) {}

double River::depth_at(const Curve::Nearest& nearest, const Vec2& at_m) const {
    if (nearest.distance_m > kBankWidths * shape_.half_width_m) return kFarAway_m;
    const double half = shape_.half_width_m * (1.0 + 0.25 * edge_.at(at_m / 12.0));
    const double across = nearest.distance_m / half;
    return shape_.depth_m * (1.0 - across * across);
}

double River::depth_m(const Vec2& at_m) const {
    return depth_at(curve_.nearest(at_m, kBankWidths * shape_.half_width_m), at_m);
}

double River::cut(const Vec2& at_m, double height_m) const {
    const Curve::Nearest nearest = curve_.nearest(at_m, kBankWidths * shape_.half_width_m);
    const double depth = depth_at(nearest, at_m);
    if (depth == kFarAway_m) return height_m;
    const double level = level_m(nearest.along);
    return std::max(level, std::min(height_m, level - depth));
}

double Lake::from_center(const Vec2& at_m) const {
    const Vec2 d = (at_m - shape_.center_m) / shape_.radii_m;
    return std::sqrt(glm::dot(d, d)) * (1.0 + 0.22 * edge_.fbm(at_m, {45.0, 3}));
}

double Lake::depth_m(const Vec2& at_m) const {
    const double away = from_center(at_m);
    return shape_.depth_m * (1.0 - away * away);
}

double Lake::cut(const Vec2& at_m, double height_m) const {
    return std::max(shape_.level_m, std::min(height_m, shape_.level_m - depth_m(at_m)));
}

}  // namespace probebake::worldgen
