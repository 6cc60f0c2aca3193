#include "objects/object_set.h"

#include <stdexcept>

namespace probebake {
namespace {

void require(bool holds, const char* problem) {
    if (!holds) throw std::invalid_argument(problem);
}

Vec3 unit_or_zero(const Vec3& v) {
    // Scaled first, so that neither tiny nor huge vectors under- or overflow when squared.
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!(largest > 0.0)) return Vec3(0.0);
    return glm::normalize(v / largest);
}

int largest_axis(const Vec3& v) {
    const Vec3 a = glm::abs(v);
    return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
}

/// Twice the area, along the normal; summed over a fan, which holds for concave polygons too.
Vec3 area_vector(std::span<const Vec3> vertices) {
    const Vec3 from = vertices[0];  // near the polygon, for the digits' sake
    Vec3 sum(0.0);
    for (size_t i = 1; i + 1 < vertices.size(); ++i) {
        sum += glm::cross(vertices[i] - from, vertices[i + 1] - from);
    }
    return sum;
}

Vec3 cone_normal(const Cone& cone, const Vec3& point) {
    const Vec3 along = cone.apex - cone.base;
    const double height = glm::length(along);
    const Vec3 axis = along / height;
    const Vec3 to = point - cone.base;
    const Vec3 outward = unit_or_zero(to - glm::dot(to, axis) * axis);
    return unit_or_zero(outward * height + axis * (cone.base_radius - cone.apex_radius));
}

}  // namespace

uint32_t ObjectSet::add_object(ShapeKind kind, size_t index) {
    constexpr size_t kMostObjects = size_t{1} << 31;
    require(objects_.size() < kMostObjects, "objects: too many");
    objects_.push_back({kind, static_cast<uint32_t>(index)});
    return static_cast<uint32_t>(objects_.size() - 1);
}

uint32_t ObjectSet::add(const Sphere& sphere) {
    require(is_finite(sphere.center) && std::isfinite(sphere.radius) && sphere.radius >= 0.0,
            "sphere: expected a finite centre and a radius that is not negative");
    spheres_.push_back(sphere);
    return add_object(ShapeKind::kSphere, spheres_.size() - 1);
}

uint32_t ObjectSet::add(const Cone& cone) {
    require(is_finite(cone.base) && is_finite(cone.apex) && std::isfinite(cone.base_radius) &&
                std::isfinite(cone.apex_radius) && cone.base_radius >= 0.0 &&
                cone.apex_radius >= 0.0,
            "cone: expected finite ends and radii that are not negative");
    require(glm::length(cone.apex - cone.base) > 0.0, "cone: expected two ends that differ");
    cones_.push_back(cone);
    return add_object(ShapeKind::kCone, cones_.size() - 1);
}

uint32_t ObjectSet::add(const Triangle& triangle) {
    require(is_finite(triangle.a) && is_finite(triangle.b) && is_finite(triangle.c),
            "triangle: expected finite vertices");
    triangles_.push_back(triangle);
    return add_object(ShapeKind::kTriangle, triangles_.size() - 1);
}

uint32_t ObjectSet::add_polygon(std::span<const Vec3> vertices) {
    require(vertices.size() >= 3, "polygon: expected three vertices or more");
    if (vertices.size() == 3) return add(Triangle{vertices[0], vertices[1], vertices[2]});
    constexpr size_t kMostVertices = size_t{1} << 31;
    require(vertices_.size() + vertices.size() < kMostVertices, "polygon: too many vertices");
    Vec3 middle(0.0);
    for (const Vec3& v : vertices) {
        require(is_finite(v), "polygon: expected finite vertices");
        middle += v / static_cast<double>(vertices.size());
    }
    Polygon polygon{.first_vertex = static_cast<uint32_t>(vertices_.size()),
                    .vertex_count = static_cast<uint32_t>(vertices.size()),
                    .normal = unit_or_zero(area_vector(vertices))};
    polygon.offset = glm::dot(polygon.normal, middle);
    polygon.drop_axis = largest_axis(polygon.normal);
    vertices_.insert(vertices_.end(), vertices.begin(), vertices.end());
    polygons_.push_back(polygon);
    return add_object(ShapeKind::kPolygon, polygons_.size() - 1);
}

Vec3 normal_at(const ObjectSet& set, uint32_t object, const Vec3& point) {
    const ObjectRef ref = set.objects()[object];
    switch (ref.kind) {
        case ShapeKind::kSphere:
            return unit_or_zero(point - set.spheres()[ref.index].center);
        case ShapeKind::kCone:
            return cone_normal(set.cones()[ref.index], point);
        case ShapeKind::kTriangle: {
            const Triangle& t = set.triangles()[ref.index];
            return unit_or_zero(glm::cross(t.b - t.a, t.c - t.a));
        }
        case ShapeKind::kPolygon:
            return set.polygons()[ref.index].normal;
    }
    return Vec3(0.0);
}

}  // namespace probebake
