#include "objects/object_bounds.h"

#include <cmath>

namespace probebake {
namespace {

Box cone_box(const Cone& cone) {
    const Vec3 axis = glm::normalize(cone.apex - cone.base);
    const Vec3 spread = glm::sqrt(glm::max(Vec3(1.0) - axis * axis, Vec3(0.0)));
    const auto disc = [&](const Vec3& center, double radius) {
        return Box{center - radius * spread, center + radius * spread};
    };
    return join(disc(cone.base, cone.base_radius), disc(cone.apex, cone.apex_radius));
}

/// Where the object can be hit: a polygon whose vertices are not in one plane is hit in the plane
/// through their middle, above or below them.
Box hit_box(const ObjectSet& set, uint32_t object) {
    Box box = object_box(set, object);
    const ObjectRef ref = set.objects()[object];
    if (ref.kind != ShapeKind::kPolygon) return box;
    const Polygon& polygon = set.polygons()[ref.index];
    if (polygon.normal == Vec3(0.0)) return box;
    const int axis = polygon.drop_axis;
    for (Vec3 v : set.vertices(polygon)) {
        v[axis] += (polygon.offset - glm::dot(polygon.normal, v)) / polygon.normal[axis];
        box = join(box, v);
    }
    return box;
}

ObjectBoxes boxes_with(const ObjectSet& set, Box (*box_of)(const ObjectSet&, uint32_t)) {
    ObjectBoxes result{.root = empty_box(), .boxes = {}};
    result.boxes.reserve(set.size());
    for (uint32_t object = 0; object < set.size(); ++object) {
        result.boxes.push_back(box_of(set, object));
        result.root = join(result.root, result.boxes.back());
    }
    if (set.size() == 0) result.root = {};
    return result;
}

}  // namespace

Box object_box(const ObjectSet& set, uint32_t object) {
    const ObjectRef ref = set.objects()[object];
    switch (ref.kind) {
        case ShapeKind::kSphere: {
            const Sphere& sphere = set.spheres()[ref.index];
            return {sphere.center - Vec3(sphere.radius), sphere.center + Vec3(sphere.radius)};
        }
        case ShapeKind::kCone:
            return cone_box(set.cones()[ref.index]);
        case ShapeKind::kTriangle: {
            const Triangle& t = set.triangles()[ref.index];
            return join(join(Box{t.a, t.a}, t.b), t.c);
        }
        case ShapeKind::kPolygon: {
            Box box = empty_box();
            for (const Vec3& v : set.vertices(set.polygons()[ref.index])) box = join(box, v);
            return box;
        }
    }
    return {};
}

Box object_box_1999(const ObjectSet& set, uint32_t object) {
    constexpr double kThin = 0.02;
    Box box = object_box(set, object);
    switch (set.objects()[object].kind) {
        case ShapeKind::kSphere:
            break;
        case ShapeKind::kCone:
            box = {box.low * 0.999, box.high * 1.001};
            break;
        case ShapeKind::kTriangle:
        case ShapeKind::kPolygon:
            for (int axis = 0; axis < 3; ++axis) {
                if (box.high[axis] - box.low[axis] < kThin) {
                    box.low[axis] -= kThin;
                    box.high[axis] += kThin;
                }
            }
            break;
    }
    return box;
}

ObjectBoxes safe_boxes(const ObjectSet& set) {
    ObjectBoxes result = boxes_with(set, hit_box);
    // Hits are off by some 1e-15 of a coordinate; a margin costs a reference where it reaches over
    // a plane, and nothing else.
    constexpr double kBoxMargin = 1e-9;
    constexpr double kRootMargin = 1e-6;
    const double scale = std::max(scale_of(result.root), 1e-300);
    for (Box& box : result.boxes) box = grown(box, kBoxMargin * scale);
    result.root = grown(result.root, kRootMargin * scale);
    return result;
}

ObjectBoxes boxes_1999(const ObjectSet& set) {
    constexpr double kRootMargin = 0.001;
    ObjectBoxes result = boxes_with(set, object_box_1999);
    result.root = grown(result.root, kRootMargin);
    return result;
}

}  // namespace probebake
