#include "scene/nff/nff_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/triangulate_polygon.h"

namespace probebake {
namespace {

/// Sides of a polygon inscribed in a circle that leave half the tolerance: on a sphere the other
/// half goes to the second direction.
uint32_t sides_of(double radius, double tolerance) {
    const double sagitta = std::min(1.0, 0.5 * tolerance / radius);
    const double angle = std::acos(1.0 - sagitta);  // half of what a side spans
    constexpr double kMost = 1e6;                   // refused as too many triangles
    const double sides = std::min(kMost, std::ceil(std::numbers::pi / std::max(angle, 1e-9)));
    return 2 * static_cast<uint32_t>(std::max(4.0, std::ceil(0.5 * sides)));
}

class Maker {
  public:
    Maker(const NffScene& scene, const NffMeshParams& params, const std::string& file)
        : scene_(scene), params_(params), file_(file) {}

    TriangleMesh run() {
        for (size_t i = 0; i < scene_.materials.size(); ++i) material(i);
        const ObjectSet& shapes = scene_.shapes;
        for (size_t i = 0; i < shapes.size(); ++i) {
            const ObjectRef ref = shapes.objects()[i];
            object_ = &scene_.objects[i];
            if (ref.kind == ShapeKind::kSphere) {
                sphere(shapes.spheres()[ref.index]);
            } else if (ref.kind == ShapeKind::kCone) {
                cone(shapes.cones()[ref.index]);
            } else if (ref.kind == ShapeKind::kTriangle) {
                const Triangle& t = shapes.triangles()[ref.index];
                polygon(std::array{t.a, t.b, t.c});
            } else {
                polygon(shapes.vertices(shapes.polygons()[ref.index]));
            }
        }
        return std::move(mesh_);
    }

  private:
    void material(size_t index) {
        const NffMaterial& from = scene_.materials[index];
        const std::string name = "material " + std::to_string(index + 1);
        mesh_.materials.push_back({.name = name,
                                   .base_color = checked_reflectance(
                                       Vec3(from.color) * from.diffuse, name, file_, mesh_)});
        if (from.transmittance > 0.0) warn(mesh_, "transmittance is left out");
    }

    void reserve(uint64_t triangles) {
        require_triangles(mesh_.triangles.size() + triangles, params_.limits, file_);
    }
    uint32_t add(const Vec3& position) {
        mesh_.positions.push_back(position);
        return static_cast<uint32_t>(mesh_.positions.size() - 1);
    }
    /// Counter-clockwise seen from outside; turned round where the inside is what is seen.
    void triangle(uint32_t a, uint32_t b, uint32_t c) {
        if (object_->inward) std::swap(b, c);
        mesh_.triangles.push_back({{a, b, c}, object_->material});
    }

    void polygon(std::span<const Vec3> corners) {
        const auto triangles = triangulate_polygon(corners);
        if (!triangles) {
            throw IoError(file_, "a concave polygon has " + std::to_string(corners.size()) +
                                     " vertices, expected at most " +
                                     std::to_string(kMaxConcaveCorners));
        }
        reserve(triangles->size());
        const auto first = static_cast<uint32_t>(mesh_.positions.size());
        for (const Vec3& corner : corners) add(corner);
        for (const auto& t : *triangles) triangle(first + t[0], first + t[1], first + t[2]);
    }

    /// A ring around `center`, counter-clockwise from u to v; returns its first vertex.
    uint32_t ring(const Vec3& center, const Vec3& u, const Vec3& v, double radius, uint32_t sides) {
        const auto first = static_cast<uint32_t>(mesh_.positions.size());
        for (uint32_t i = 0; i < sides; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / sides;
            add(center + radius * (std::cos(angle) * u + std::sin(angle) * v));
        }
        return first;
    }
    /// Between two rings, the second farther along cross(u, v).
    void band(uint32_t low, uint32_t high, uint32_t sides) {
        for (uint32_t i = 0; i < sides; ++i) {
            const uint32_t next = (i + 1) % sides;
            triangle(low + i, low + next, high + next);
            triangle(low + i, high + next, high + i);
        }
    }
    /// From a ring to a point farther along cross(u, v), or nearer.
    void cap(uint32_t first, uint32_t top, uint32_t sides, bool above) {
        for (uint32_t i = 0; i < sides; ++i) {
            const uint32_t next = (i + 1) % sides;
            if (above) {
                triangle(first + i, first + next, top);
            } else {
                triangle(first + next, first + i, top);
            }
        }
    }

    void sphere(const Sphere& sphere) {
        if (!(sphere.radius > 0.0)) return;
        const uint32_t sides = sides_of(sphere.radius, params_.tolerance);
        const uint32_t bands = sides / 2;
        reserve(uint64_t{2} * sides * (bands - 1));
        const Vec3 u(0.0, 0.0, 1.0);
        const Vec3 v(1.0, 0.0, 0.0);  // cross(u, v) = +Y
        const Vec3 up(0.0, sphere.radius, 0.0);
        uint32_t below = add(sphere.center - up);
        for (uint32_t i = 1; i < bands; ++i) {
            const double angle = std::numbers::pi * i / bands;  // from −Y
            const uint32_t at = ring(sphere.center - std::cos(angle) * up, u, v,
                                     sphere.radius * std::sin(angle), sides);
            if (i == 1) {
                cap(at, below, sides, false);
            } else {
                band(below, at, sides);
            }
            below = at;
        }
        cap(below, add(sphere.center + up), sides, true);
    }

    void cone(const Cone& cone) {
        const double radius = std::max(cone.base_radius, cone.apex_radius);
        if (!(radius > 0.0)) return;
        const uint32_t sides = sides_of(radius, params_.tolerance);
        reserve(uint64_t{2} * sides);
        const Vec3 axis = glm::normalize(cone.apex - cone.base);
        const Vec3 other = std::abs(axis.x) < 0.5 ? Vec3(1.0, 0.0, 0.0) : Vec3(0.0, 1.0, 0.0);
        const Vec3 u = glm::normalize(glm::cross(axis, other));
        const Vec3 v = glm::cross(axis, u);
        if (!(cone.apex_radius > 0.0)) {
            const uint32_t low = ring(cone.base, u, v, cone.base_radius, sides);
            cap(low, add(cone.apex), sides, true);
        } else if (!(cone.base_radius > 0.0)) {
            const uint32_t high = ring(cone.apex, u, v, cone.apex_radius, sides);
            cap(high, add(cone.base), sides, false);
        } else {
            const uint32_t low = ring(cone.base, u, v, cone.base_radius, sides);
            band(low, ring(cone.apex, u, v, cone.apex_radius, sides), sides);
        }
    }

    const NffScene& scene_;
    const NffMeshParams& params_;
    const std::string& file_;
    const NffObject* object_ = nullptr;
    TriangleMesh mesh_;
};

}  // namespace

TriangleMesh nff_mesh(const NffScene& scene, const NffMeshParams& params, const std::string& file) {
    return Maker(scene, params, file).run();
}

}  // namespace probebake
