// Where rays meet primitives: the nearest t inside an open range, infinity for none.
//
// Directions are of unit length and origins near the primitives (local_ray.h). No test has an
// absolute threshold. Spheres by the distance of their centre from the ray (Haines et al., Ray
// Tracing Gems 7), cones by the stable quadratic about the point next to their base, triangles
// watertight (Woop, Benthin, Wald 2013): a ray through a shared edge or vertex meets one of its
// triangles. Polygons by their plane and the parity of edges crossed in the projection along the
// normal's largest component.
#pragma once

#include "objects/object_set.h"

namespace probebake {

/// A ray and what the triangle test keeps of it.
struct PreparedRay {
    explicit PreparedRay(const Ray& given);

    Ray ray;
    int kx, ky, kz;  // kz is the direction's largest component
    Vec3 shear{0.0};
};

double intersect(const Sphere& sphere, const PreparedRay& ray, const TRange& range);
double intersect(const Cone& cone, const PreparedRay& ray, const TRange& range);
double intersect(const Triangle& triangle, const PreparedRay& ray, const TRange& range);
double intersect(const Polygon& polygon, std::span<const Vec3> vertices, const PreparedRay& ray,
                 const TRange& range);
double intersect(const ObjectSet& set, uint32_t object, const PreparedRay& ray,
                 const TRange& range);

}  // namespace probebake
