// The leaves of an octree along a ray, front to back, found in three ways.
//
//   kFromRoot       Glassner 1984: the next leaf is located from the root.
//   kFromAncestor   Samet 1989: up to the nearest ancestor that the ray stays in, and down again.
//   kTopDown        Gargantini and Atkinson 1993: the children of a node in the order in which
//                   the ray crosses its planes.
//
// All three use one arithmetic: a plane's parameter is the double (plane − origin) · (1 /
// direction) wherever it is met, children are chosen by parameters alone, a plane that is met at t
// counts as passed at t. The intervals of the leaves therefore tile the ray's part of the box
// exactly, have positive length, and are the same for all three; no epsilon, no special case.
// Deviation: Glassner and Samet locate the next leaf by the coordinates of a point beyond the exit
// face; points that rounding puts on the wrong side of a plane cost prototypes 13 to 49 % of the
// rays of some families. Samet's descent mirrors the path of equal-sized cells, which needs centre
// planes; here it compares, so that any planes will do. The nodes visited are theirs.
#pragma once

#include <array>
#include <cstdint>

#include "octree/octree.h"

namespace probebake {

enum class OctreeTraversal : uint8_t { kFromRoot, kFromAncestor, kTopDown };

struct WalkCounts {
    /// Nodes visited, root and leaves included. kFromRoot: the path from the root at every
    /// location. kFromAncestor: the path to the first leaf, then every node gone up to and every
    /// node gone down to. kTopDown: every node entered.
    uint64_t steps = 0;
    uint64_t leaves = 0;
    uint64_t empty_leaves = 0;

    WalkCounts& operator+=(const WalkCounts& other) {
        steps += other.steps;
        leaves += other.leaves;
        empty_leaves += other.empty_leaves;
        return *this;
    }
};

/// What all three share of a ray. Children are numbered along the ray: bit a of a child is set when
/// it lies behind plane a as the ray comes; child ^ mirror is its octant.
struct OctreeRay {
    explicit OctreeRay(const Ray& ray) : origin(ray.origin) {
        const Vec3 direction = safe_direction(ray.direction);
        inverse = 1.0 / direction;
        for (int axis = 0; axis < 3; ++axis) {
            if (direction[axis] < 0.0) mirror |= 1u << axis;
        }
    }
    Vec3 t_of(const Vec3& planes) const { return (planes - origin) * inverse; }
    /// Where each axis's first and last plane of the box is crossed.
    Vec3 t_near(const Box& box) const { return glm::min(t_of(box.low), t_of(box.high)); }
    Vec3 t_far(const Box& box) const { return glm::max(t_of(box.low), t_of(box.high)); }

    Vec3 origin;
    Vec3 inverse{0.0};
    uint32_t mirror = 0;
};

inline double least(const Vec3& t) { return std::min(std::min(t.x, t.y), t.z); }

/// The child of a node that the ray is in at t, in the numbering along the ray.
inline uint32_t passed_planes(const Vec3& t_planes, double t) {
    return (t_planes.x <= t ? 1u : 0u) | (t_planes.y <= t ? 2u : 0u) | (t_planes.z <= t ? 4u : 0u);
}

/// Where each axis leaves that child.
inline Vec3 far_of_child(const Vec3& t_far, const Vec3& t_planes, uint32_t child) {
    return {(child & 1u) != 0 ? t_far.x : t_planes.x, (child & 2u) != 0 ? t_far.y : t_planes.y,
            (child & 4u) != 0 ? t_far.z : t_planes.z};
}

namespace octree_walk {

/// Counts the leaf and shows it; true where the walk is over.
template <class Visit>
bool show(OctreeRef leaf, double t, double exit, WalkCounts& counts, Visit& visit) {
    ++counts.leaves;
    if (leaf.is_empty()) {
        ++counts.empty_leaves;
        return false;
    }
    return visit(leaf.number(), t, exit);
}

template <class Visit>
void from_root(const Octree& tree, const OctreeRay& ray, double t, double end, const Vec3& root_far,
               WalkCounts& counts, Visit& visit) {
    while (t < end) {
        OctreeRef ref = tree.root();
        Vec3 t_far = root_far;
        ++counts.steps;
        while (!ref.is_leaf()) {
            const Octree::Node& node = tree.node(ref);
            const Vec3 t_planes = ray.t_of(node.planes);
            const uint32_t child = passed_planes(t_planes, t);
            t_far = far_of_child(t_far, t_planes, child);
            ref = node.children[child ^ ray.mirror];
            ++counts.steps;
        }
        const double exit = least(t_far);
        if (show(ref, t, exit, counts, visit)) return;
        t = exit;
    }
}

template <class Visit>
void from_ancestor(const Octree& tree, const OctreeRay& ray, double t, double range_end,
                   const Vec3& root_far, WalkCounts& counts, Visit& visit) {
    struct Above {
        OctreeRef ref;
        Vec3 t_far;
        double exit;
    };
    std::array<Above, kMaxOctreeDepth + 1> path;
    path[0] = {tree.root(), root_far, least(root_far)};
    size_t level = 0;
    ++counts.steps;
    for (;;) {
        while (!path[level].ref.is_leaf()) {
            const Octree::Node& node = tree.node(path[level].ref);
            const Vec3 t_planes = ray.t_of(node.planes);
            const uint32_t child = passed_planes(t_planes, t);
            const Vec3 t_far = far_of_child(path[level].t_far, t_planes, child);
            path[++level] = {node.children[child ^ ray.mirror], t_far, least(t_far)};
            ++counts.steps;
        }
        const double exit = path[level].exit;
        if (show(path[level].ref, t, exit, counts, visit)) return;
        t = exit;
        if (!(t < range_end)) return;
        // Out of the root, too, the way leads through all ancestors: only there it is known that
        // there is no neighbour.
        while (path[level].exit <= t) {
            if (level == 0) return;
            --level;
            ++counts.steps;
        }
    }
}

template <class Visit>
void top_down(const Octree& tree, const OctreeRay& ray, double t, double end, const Vec3& root_far,
              WalkCounts& counts, Visit& visit) {
    struct Frame {
        const Octree::Node* node;
        Vec3 t_planes;
        double exit;
        uint32_t child;
    };
    std::array<Frame, kMaxOctreeDepth + 1> frames;
    size_t level = 0;
    const auto open = [&](OctreeRef ref, double exit) {
        Frame& frame = frames[level];
        frame.node = &tree.node(ref);
        frame.t_planes = ray.t_of(frame.node->planes);
        frame.exit = exit;
        frame.child = passed_planes(frame.t_planes, t);
    };
    ++counts.steps;
    const double root_exit = least(root_far);
    if (tree.root().is_leaf()) {
        show(tree.root(), t, root_exit, counts, visit);
        return;
    }
    open(tree.root(), root_exit);
    while (t < end) {
        Frame& frame = frames[level];
        const OctreeRef ref = frame.node->children[frame.child ^ ray.mirror];
        const double exit = least(far_of_child(Vec3(frame.exit), frame.t_planes, frame.child));
        ++counts.steps;
        if (!ref.is_leaf()) {
            ++level;
            open(ref, exit);
            continue;
        }
        if (show(ref, t, exit, counts, visit)) return;
        t = exit;
        while (frames[level].exit <= t) {
            if (level == 0) return;
            --level;
        }
        frames[level].child |= passed_planes(frames[level].t_planes, t);
    }
}

}  // namespace octree_walk

/// Calls visit(leaf number, t in, t out) for every leaf that is not empty, until it returns true.
/// `range` cuts the ray: the first leaf is the one that holds range.begin, the last one begins
/// before range.end. Requires a finite ray with a direction, of any length.
template <class Visit>
void walk(const Octree& tree, OctreeTraversal how, const Ray& ray, const TRange& range,
          WalkCounts& counts, Visit&& visit) {
    const OctreeRay octree_ray(ray);
    const Vec3 t_near = octree_ray.t_near(tree.box());
    const Vec3 t_far = octree_ray.t_far(tree.box());
    const double t = std::max(std::max(std::max(t_near.x, t_near.y), t_near.z), range.begin);
    const double end = std::min(least(t_far), range.end);
    if (!(t < end)) return;
    switch (how) {
        case OctreeTraversal::kFromRoot:
            octree_walk::from_root(tree, octree_ray, t, end, t_far, counts, visit);
            break;
        case OctreeTraversal::kFromAncestor:
            octree_walk::from_ancestor(tree, octree_ray, t, range.end, t_far, counts, visit);
            break;
        case OctreeTraversal::kTopDown:
            octree_walk::top_down(tree, octree_ray, t, end, t_far, counts, visit);
            break;
    }
}

}  // namespace probebake
