#include "objects/object_octree.h"

#include "objects/intersect.h"

namespace probebake {
namespace {

/// Keeps the nearest hit; of equal ones the lowest object.
void test_object(const ObjectSet& set, uint32_t object, const PreparedRay& ray, const TRange& range,
                 ObjectHit& best) {
    const double t = intersect(set, object, ray, range);
    if (t < best.t || (t == best.t && object < best.object && t < kInfinity)) best = {t, object};
}

}  // namespace

ObjectHit ObjectOctree::closest_hit(const Ray& ray, const TRange& range, OctreeTraversal how,
                                    CastCounts& counts) const {
    const auto local = local_ray(octree_.tree().box(), ray, range);
    if (!local) return {};
    const PreparedRay prepared(local->ray);
    ObjectHit best;
    walk(octree_.tree(), how, local->ray, local->range, counts.walk,
         [&](uint32_t leaf, double, double exit) {
             for (const uint32_t object : octree_.items(leaf)) {
                 ++counts.tests;
                 test_object(set_, object, prepared, local->range, best);
             }
             return best.t < exit;
         });
    if (best) best.t = local->t_given(best.t);
    return best;
}

ObjectHit ObjectOctree::any_hit(const Ray& ray, const TRange& range, OctreeTraversal how,
                                CastCounts& counts) const {
    const auto local = local_ray(octree_.tree().box(), ray, range);
    if (!local) return {};
    const PreparedRay prepared(local->ray);
    ObjectHit found;
    walk(octree_.tree(), how, local->ray, local->range, counts.walk,
         [&](uint32_t leaf, double, double) {
             for (const uint32_t object : octree_.items(leaf)) {
                 ++counts.tests;
                 const double t = intersect(set_, object, prepared, local->range);
                 if (t < kInfinity) {
                     found = {local->t_given(t), object};
                     return true;
                 }
             }
             return false;
         });
    return found;
}

ObjectHit closest_hit_of_all(const ObjectSet& set, const Box& root, const Ray& ray,
                             const TRange& range) {
    const auto local = local_ray(root, ray, range);
    if (!local) return {};
    const PreparedRay prepared(local->ray);
    ObjectHit best;
    for (uint32_t object = 0; object < set.size(); ++object) {
        test_object(set, object, prepared, local->range, best);
    }
    if (best) best.t = local->t_given(best.t);
    return best;
}

}  // namespace probebake
