// ObjectOctree: rays against an ObjectSet through an octree, closest hit and any hit.
//
// Each leaf's objects are tested in turn; a hit ends the walk once it lies in or before the leaf.
// An object in several leaves is tested in each of them (no mailboxes, as in Havran 1999). The
// answer does not depend on how the tree is walked, and is that of testing every object.
#pragma once

#include "objects/local_ray.h"
#include "objects/object_bounds.h"
#include "octree/item_octree.h"
#include "octree/walk.h"

namespace probebake {

struct ObjectHit {
    static constexpr uint32_t kNone = ~uint32_t{0};

    double t = kInfinity;  // in lengths of the ray's direction
    uint32_t object = kNone;

    explicit operator bool() const { return object != kNone; }
    bool operator==(const ObjectHit&) const = default;
};

struct CastCounts {
    WalkCounts walk;
    uint64_t tests = 0;  // of rays against objects

    CastCounts& operator+=(const CastCounts& other) {
        walk += other.walk;
        tests += other.tests;
        return *this;
    }
};

class ObjectOctree {
  public:
    /// Keeps a reference to the set. `boxes` as safe_boxes makes them, where every hit matters.
    ObjectOctree(const ObjectSet& set, const ObjectBoxes& boxes, const ItemOctreeParams& params)
        : set_(set), octree_(boxes.root, boxes.boxes, params) {}

    const ItemOctree& octree() const { return octree_; }

    /// The nearest hit with range.begin < t < range.end; none for rays that are not finite or have
    /// no direction.
    ObjectHit closest_hit(const Ray& ray, const TRange& range, OctreeTraversal how,
                          CastCounts& counts) const;
    ObjectHit closest_hit(const Ray& ray, const TRange& range = {}) const {
        CastCounts counts;
        return closest_hit(ray, range, OctreeTraversal::kTopDown, counts);
    }
    /// Some hit in the range: the first that is found.
    ObjectHit any_hit(const Ray& ray, const TRange& range, OctreeTraversal how,
                      CastCounts& counts) const;
    bool any_hit(const Ray& ray, const TRange& range = {}) const {
        CastCounts counts;
        return static_cast<bool>(any_hit(ray, range, OctreeTraversal::kTopDown, counts));
    }

  private:
    const ObjectSet& set_;
    ItemOctree octree_;
};

/// The same answer by testing every object: what closest_hit is checked against.
ObjectHit closest_hit_of_all(const ObjectSet& set, const Box& root, const Ray& ray,
                             const TRange& range = {});

}  // namespace probebake
