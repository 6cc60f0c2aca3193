#include "objects/intersect.h"

#include <cmath>
#include <utility>

namespace probebake {
namespace {

bool inside(const TRange& range, double t) { return t > range.begin && t < range.end; }

/// Of two roots in order, the first in the range that `accept` takes.
template <class Accept>
double first_root(double t0, double t1, const TRange& range, Accept accept) {
    if (inside(range, t0) && accept(t0)) return t0;
    if (inside(range, t1) && accept(t1)) return t1;
    return kInfinity;
}

}  // namespace

PreparedRay::PreparedRay(const Ray& given) : ray(given) {
    const Vec3 size = glm::abs(ray.direction);
    kz = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    kx = (kz + 1) % 3;
    ky = (kx + 1) % 3;
    if (ray.direction[kz] < 0.0) std::swap(kx, ky);
    shear = {ray.direction[kx] / ray.direction[kz], ray.direction[ky] / ray.direction[kz],
             1.0 / ray.direction[kz]};
}

double intersect(const Sphere& sphere, const PreparedRay& prepared, const TRange& range) {
    const Ray& ray = prepared.ray;
    const Vec3 to = sphere.center - ray.origin;
    const double middle = glm::dot(to, ray.direction);
    const Vec3 off = to - middle * ray.direction;
    const double square = sphere.radius * sphere.radius - glm::dot(off, off);
    if (!(square >= 0.0)) return kInfinity;
    const double half = std::sqrt(square);
    return first_root(middle - half, middle + half, range, [](double) { return true; });
}

double intersect(const Cone& cone, const PreparedRay& prepared, const TRange& range) {
    const Ray& ray = prepared.ray;
    const Vec3 along = cone.apex - cone.base;
    const double height = glm::length(along);
    const Vec3 axis = along / height;
    const double slope = (cone.apex_radius - cone.base_radius) / height;

    // From the ray's point next to the base: where the coefficients lose fewest digits.
    const double t_base = glm::dot(cone.base - ray.origin, ray.direction);
    const Vec3 from = ray.origin + t_base * ray.direction - cone.base;
    const double s0 = glm::dot(from, axis);  // height on the axis: s0 + t s1
    const double s1 = glm::dot(ray.direction, axis);
    const Vec3 off = from - s0 * axis;
    const Vec3 off_step = ray.direction - s1 * axis;
    const double radius = cone.base_radius + slope * s0;
    const double radius_step = slope * s1;

    // |off + t off_step|² = (radius + t radius_step)²: a t² + 2 b t + c = 0.
    const double a = glm::dot(off_step, off_step) - radius_step * radius_step;
    const double b = glm::dot(off, off_step) - radius * radius_step;
    const double c = glm::dot(off, off) - radius * radius;
    const double square = b * b - a * c;
    if (!(square >= 0.0)) return kInfinity;
    const double q = -(b + std::copysign(std::sqrt(square), b));
    // With a = 0 the first is infinite or NaN, with a = b = 0 both are: outside of every range.
    double t0 = t_base + q / a;
    double t1 = t_base + c / q;
    if (t1 < t0) std::swap(t0, t1);
    const auto between_ends = [&](double t) {
        const double s = s0 + (t - t_base) * s1;
        return s >= 0.0 && s <= height;
    };
    return first_root(t0, t1, range, between_ends);
}

double intersect(const Triangle& triangle, const PreparedRay& ray, const TRange& range) {
    const auto sheared = [&](const Vec3& vertex) {
        const Vec3 v = vertex - ray.ray.origin;
        const double z = v[ray.kz];
        return Vec3(v[ray.kx] - ray.shear.x * z, v[ray.ky] - ray.shear.y * z, ray.shear.z * z);
    };
    const Vec3 a = sheared(triangle.a);
    const Vec3 b = sheared(triangle.b);
    const Vec3 c = sheared(triangle.c);
    const double u = c.x * b.y - c.y * b.x;
    const double v = a.x * c.y - a.y * c.x;
    const double w = b.x * a.y - b.y * a.x;
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return kInfinity;
    const double area = u + v + w;
    // A triangle seen edge-on has none: not hit.
    const double t = (u * a.z + v * b.z + w * c.z) / area;
    return inside(range, t) ? t : kInfinity;
}

double intersect(const Polygon& polygon, std::span<const Vec3> vertices,
                 const PreparedRay& prepared, const TRange& range) {
    const Ray& ray = prepared.ray;
    const double along = glm::dot(polygon.normal, ray.direction);
    const double t = (polygon.offset - glm::dot(polygon.normal, ray.origin)) / along;
    if (!inside(range, t)) return kInfinity;
    const int kx = (polygon.drop_axis + 1) % 3;
    const int ky = (polygon.drop_axis + 2) % 3;
    const double x = ray.origin[kx] + t * ray.direction[kx];
    const double y = ray.origin[ky] + t * ray.direction[ky];
    bool odd = false;
    const Vec3* previous = &vertices.back();
    for (const Vec3& vertex : vertices) {
        // Upwards, so that both polygons at an edge reckon it alike.
        const Vec3& low = (*previous)[ky] <= vertex[ky] ? *previous : vertex;
        const Vec3& high = &low == previous ? vertex : *previous;
        if (low[ky] <= y && high[ky] > y) {
            const double beyond =
                (high[kx] - low[kx]) * (y - low[ky]) - (x - low[kx]) * (high[ky] - low[ky]);
            if (beyond > 0.0) odd = !odd;
        }
        previous = &vertex;
    }
    return odd ? t : kInfinity;
}

double intersect(const ObjectSet& set, uint32_t object, const PreparedRay& ray,
                 const TRange& range) {
    const ObjectRef ref = set.objects()[object];
    switch (ref.kind) {
        case ShapeKind::kSphere:
            return intersect(set.spheres()[ref.index], ray, range);
        case ShapeKind::kCone:
            return intersect(set.cones()[ref.index], ray, range);
        case ShapeKind::kTriangle:
            return intersect(set.triangles()[ref.index], ray, range);
        case ShapeKind::kPolygon: {
            const Polygon& polygon = set.polygons()[ref.index];
            return intersect(polygon, set.vertices(polygon), ray, range);
        }
    }
    return kInfinity;
}

}  // namespace probebake
