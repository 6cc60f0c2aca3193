#include "scene/generators/curve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/random.h"

namespace probebake::worldgen {
namespace {

constexpr int kPiecesPerPoint = 8;
constexpr int kRoughSide = 64;

std::vector<Vec2> subdivide(const std::vector<Vec2>& through) {
    const auto count = static_cast<int>(through.size());
    const auto point = [&](int i) {
        return through[static_cast<size_t>(std::clamp(i, 0, count - 1))];
    };
    std::vector<Vec2> points;
    for (int i = 0; i + 1 < count; ++i) {
        const Vec2 p0 = point(i - 1), p1 = point(i), p2 = point(i + 1), p3 = point(i + 2);
        for (int k = 0; k < kPiecesPerPoint; ++k) {
            const double t = static_cast<double>(k) / kPiecesPerPoint;
            points.push_back(0.5 * (2.0 * p1 + (p2 - p0) * t +
                                    (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * (t * t) +
                                    (3.0 * p1 - p0 - 3.0 * p2 + p3) * (t * t * t)));
        }
    }
    points.push_back(through.back());
    return points;
}

struct Foot {
    double distance_m;
    double begin_share;  // along the segment
    size_t segment;
};

Foot nearest_on(const std::vector<Vec2>& points, const Vec2& at) {
    Foot best{std::numeric_limits<double>::infinity(), 0.0, 0};
    for (size_t i = 0; i + 1 < points.size(); ++i) {
        const Vec2 along = points[i + 1] - points[i];
        const double t =
            std::clamp(glm::dot(at - points[i], along) / glm::dot(along, along), 0.0, 1.0);
        const Vec2 away = points[i] + along * t - at;
        const double squared = glm::dot(away, away);
        if (squared < best.distance_m) best = {squared, t, i};
    }
    best.distance_m = std::sqrt(best.distance_m);
    return best;
}

}  // namespace

std::vector<Vec2> jittered(std::vector<Vec2> points_m, const Vec2& reach_m, uint64_t key) {
    RandomStream random(key);
    for (Vec2& point : points_m) {
        point.x += reach_m.x * (2.0 * random.uniform() - 1.0);
        point.y += reach_m.y * (2.0 * random.uniform() - 1.0);
    }
    return points_m;
}

Curve::Curve(const std::vector<Vec2>& through_m)
    : points_m_(subdivide(through_m)), rough_distance_m_(kRoughSide, [this](const Vec2& at) {
          return nearest_on(points_m_, at).distance_m;
      }) {
    begins_m_.push_back(0.0);
    for (size_t i = 1; i < points_m_.size(); ++i) {
        begins_m_.push_back(begins_m_.back() + glm::length(points_m_[i] - points_m_[i - 1]));
    }
}

Curve::Nearest Curve::nearest(const Vec2& at_m, double reach_m) const {
    // A distance field changes by at most the way to the cell's centre.
    const double rough = rough_distance_m_.nearest_value(at_m);
    const double slack = 0.75 * rough_distance_m_.cell_m();
    if (rough - slack > reach_m) return {rough - slack, 0.0};
    const Foot foot = nearest_on(points_m_, at_m);
    const double begin = begins_m_[foot.segment];
    const double end = begins_m_[foot.segment + 1];
    return {foot.distance_m, (begin + foot.begin_share * (end - begin)) / length_m()};
}

Vec2 Curve::at(double along) const {
    const double target = std::clamp(along, 0.0, 1.0) * length_m();
    const auto next = std::upper_bound(begins_m_.begin() + 1, begins_m_.end() - 1, target);
    const auto i = static_cast<size_t>(next - begins_m_.begin());
    const double t = (target - begins_m_[i - 1]) / (begins_m_[i] - begins_m_[i - 1]);
    return points_m_[i - 1] + (points_m_[i] - points_m_[i - 1]) * t;
}

}  // namespace probebake::worldgen
