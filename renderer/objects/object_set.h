// ObjectSet: the shapes that an object octree holds.
//
// Spheres, cones (a cylinder is one of equal radii; open, without caps), flat polygons (concave
// too), triangles. An object's number is its place in the order of adding; where two are met at the
// same distance, the lower number counts. Units are the caller's.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/box.h"

namespace probebake {

struct Sphere {
    Vec3 center{0.0};
    double radius = 0.0;  // ≥ 0
};

struct Cone {
    Vec3 base{0.0};
    double base_radius = 0.0;  // ≥ 0
    Vec3 apex{0.0};            // not the base
    double apex_radius = 0.0;  // ≥ 0
};

struct Triangle {
    Vec3 a{0.0};
    Vec3 b{0.0};
    Vec3 c{0.0};
};

/// Vertices stand in the set; counter-clockwise around the normal. Planar up to rounding: it is the
/// plane through the vertices' middle that is hit. A polygon without area is never hit.
struct Polygon {
    uint32_t first_vertex = 0;
    uint32_t vertex_count = 0;
    Vec3 normal{0.0};     // unit; zero where there is no area
    double offset = 0.0;  // dot(normal, p) of its plane
    int drop_axis = 0;    // the largest component of the normal
};

enum class ShapeKind : uint8_t { kSphere, kCone, kTriangle, kPolygon };

/// Which shape an object is, and where it stands among those of its kind.
struct ObjectRef {
    ShapeKind kind = ShapeKind::kSphere;
    uint32_t index = 0;
};

class ObjectSet {
  public:
    // Each returns the object's number, and throws std::invalid_argument where the shape is not
    // finite, a radius is negative or a cone has no axis.
    uint32_t add(const Sphere& sphere);
    uint32_t add(const Cone& cone);
    uint32_t add(const Triangle& triangle);
    /// Three vertices or more; a triangle where there are three.
    uint32_t add_polygon(std::span<const Vec3> vertices);

    size_t size() const { return objects_.size(); }
    const std::vector<ObjectRef>& objects() const { return objects_; }
    const std::vector<Sphere>& spheres() const { return spheres_; }
    const std::vector<Cone>& cones() const { return cones_; }
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const std::vector<Polygon>& polygons() const { return polygons_; }
    std::span<const Vec3> vertices(const Polygon& polygon) const {
        return std::span(vertices_).subspan(polygon.first_vertex, polygon.vertex_count);
    }

  private:
    uint32_t add_object(ShapeKind kind, size_t index);

    std::vector<ObjectRef> objects_;
    std::vector<Sphere> spheres_;
    std::vector<Cone> cones_;
    std::vector<Triangle> triangles_;
    std::vector<Polygon> polygons_;
    std::vector<Vec3> vertices_;
};

/// Unit normal at a point of the object's surface: outwards for spheres and cones, the side from
/// which the vertices turn counter-clockwise for the others; zero where there is none.
Vec3 normal_at(const ObjectSet& set, uint32_t object, const Vec3& point);

}  // namespace probebake
