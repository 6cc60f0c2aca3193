#include "track/media_line.h"

#include <numbers>

namespace probebake {

DensityCursor::DensityCursor(const Medium& medium, const Ray& ray_m, const TRange& range) {
    if (const auto* grid = std::get_if<GridShape>(&medium.spec.shape)) {
        kind_ = Kind::kGrid;
        grid_ = grid->density.get();
        emission_ = grid->emission.get();
        origin_ = medium.world_to_index.point(ray_m.origin);
        direction_ = medium.world_to_index.vector(ray_m.direction);
        walk_ = OctreeWalk(medium.octree,
                           {medium.world_to_units.point(ray_m.origin),
                            medium.world_to_units.vector(ray_m.direction)},
                           range);
        return;
    }
    const auto inside = clip(medium.box, {ray_m.origin, safe_direction(ray_m.direction)}, range);
    if (inside) {
        t_ = inside->begin;
        end_ = inside->end;
    }
    if (const auto* fog = std::get_if<FogShape>(&medium.spec.shape)) {
        kind_ = Kind::kFog;
        origin_.y = (ray_m.origin.y - fog->base_m) / fog->scale_height_m;
        direction_.y = ray_m.direction.y / fog->scale_height_m;
    }
}

bool DensityCursor::next(DensitySegment& segment) {
    if (kind_ == Kind::kGrid) return walk_.next(segment);
    if (!(t_ < end_)) return false;
    if (kind_ == Kind::kFog) return next_fog(segment);
    segment = {t_, end_, 1.0, 1.0};
    t_ = end_;
    return true;
}

// Below the base one piece; above it stretches over which the density changes by a factor of 2.
bool DensityCursor::next_fog(DensitySegment& segment) {
    const double dy = direction_.y;
    const double to_base = -origin_.y / dy;  // infinite or NaN along the horizon
    // By the border's own t, never by a position: at the border itself rounding would decide.
    const bool below = dy > 0.0 ? to_base > t_ : dy < 0.0 ? !(to_base > t_) : origin_.y < 0.0;
    double to = end_;
    if (below) {
        if (dy > 0.0) to = std::min(to, to_base);
    } else {
        to = std::min(to, t_ + std::numbers::ln2 / std::abs(dy));
        if (dy < 0.0) to = std::min(to, to_base);
    }
    if (!(to > t_)) to = end_;  // less than a rounding step from a border
    const double a = density(t_);
    const double b = density(to);
    constexpr double kRounding = 1e-12;
    segment = {t_, to, std::min(a, b) * (1.0 - kRounding),
               std::min(1.0, std::max(a, b) * (1.0 + kRounding))};
    if (below) segment.least = segment.most = 1.0;
    t_ = to;
    return true;
}

double DensityCursor::simple_density(double t) const {
    if (kind_ == Kind::kHomogeneous) return 1.0;
    return std::exp(-std::max(0.0, origin_.y + direction_.y * t));
}

double DensityCursor::emission_scale(double t) const {
    return emission_ != nullptr ? emission_->sample(origin_ + direction_ * t) : 1.0;
}

}  // namespace probebake
