#include "objects/local_ray.h"

namespace probebake {

std::optional<LocalRay> local_ray(const Box& box, const Ray& ray, const TRange& range) {
    if (!is_finite(ray.origin) || !is_finite(ray.direction)) return std::nullopt;
    const Vec3& d = ray.direction;
    const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    if (!(largest > 0.0)) return std::nullopt;
    const double length_of_scaled = glm::length(d / largest);
    LocalRay local;
    local.unit = largest * length_of_scaled;
    local.ray = {ray.origin, d / largest / length_of_scaled};
    local.range = {range.begin * local.unit, range.end * local.unit};
    const Ray safe{ray.origin, safe_direction(local.ray.direction)};
    const auto inside = clip(box, safe, local.range);
    if (!inside) return std::nullopt;
    const auto entry = clip(box, safe, {-kInfinity, kInfinity});
    if (entry && entry->begin > 0.0) {
        local.t_entry = entry->begin;
        local.ray.origin += local.t_entry * local.ray.direction;
        local.range.begin -= local.t_entry;
        local.range.end -= local.t_entry;
    }
    return local;
}

}  // namespace probebake
