#include "voxels/trace.h"

#include <algorithm>
#include <bit>

#include "voxels/start_list.h"

namespace probebake {
namespace {

/// An octree node on the way down. Children are numbered along the ray: bit a of a child is set
/// when it lies behind the mid-plane of axis a as the ray comes; child ^ mirror is its octant.
struct Frame {
    Vec3 t_mid;         // where the ray crosses the three mid-planes
    double t_exit;      // where it leaves the node
    IVec3 corner;       // lowest voxel
    uint32_t node;      // the 64-ary node that holds it
    uint32_t octant;    // which octant of that node, at odd levels
    uint32_t children;  // its child mask
    uint32_t current;   // the child being visited
};

class Traversal {
  public:
    Traversal(const VoxelTree& tree, const Ray& ray)
        : nodes_(tree.nodes()),
          origin_(ray.origin),
          direction_(ray.direction),
          depth_(tree.depth()) {
        const Vec3 direction = safe_direction(ray.direction);
        inverse_ = 1.0 / direction;
        for (int axis = 0; axis < 3; ++axis) {
            if (direction[axis] < 0.0) mirror_ |= 1u << axis;
        }
    }

    /// With `passed`, the first node that `lod` calls opaque is noted there and gone into.
    Hit run(const LevelOfDetail& lod, const TraceRange& range, StopRule* rule,
            Hit* passed = nullptr) {
        const double t = t_enter_of({0, 0, 0}, 1 << depth_);
        const double t_exit = t_exit_of({0, 0, 0}, 1 << depth_);
        if (!(t < t_exit) || !(t_exit > range.t_min) || t > range.t_max) return {};
        push_root(t, t_exit);
        start_level_ = depth_;
        Hit hit;
        walk(t, lod, range, rule, passed, hit);
        return hit;
    }

    /// The same from the nodes that are first on the way of a beam that the ray belongs to.
    Hit run_from(const StartList& list, const LevelOfDetail& lod, const TraceRange& range,
                 Hit* passed) {
        uint32_t tests = 0;
        Hit hit;
        for (const StartNode& node : list.nodes) {
            const Vec3 to_low = (node.low - origin_) * inverse_;
            const Vec3 to_high = (node.high - origin_) * inverse_;
            const Vec3 in = glm::min(to_low, to_high);
            const Vec3 out = glm::max(to_low, to_high);
            const double t = std::max({in.x, in.y, in.z});
            const double t_exit = std::min({out.x, out.y, out.z});
            ++tests;
            if (!(t < t_exit) || !(t_exit > range.t_min)) continue;
            if (t > range.t_max) break;
            push_start(node, t, t_exit);
            const bool opaque = node.level < depth_ && t >= range.t_min &&
                                static_cast<double>(1 << node.level) <= lod.cone * t;
            if (passed != nullptr && !*passed && opaque) {
                describe(node.corner, node.level, t, *passed);
                passed->path = node.path;
            }
            if (node.level < depth_) ++hit.steps;
            walk(t, lod, range, nullptr, passed, hit);
            if (hit) break;
        }
        hit.box_tests = tests;
        return hit;
    }

  private:
    /// From the start node on; adds to the steps of `hit`, which stays a miss where there is none.
    void walk(double t, const LevelOfDetail& lod, const TraceRange& range, StopRule* rule,
              Hit* passed, Hit& hit) {
        int level = start_level_;
        for (;;) {
            Frame& frame = frames_[static_cast<size_t>(level)];
            const double child_exit = exit_of_current(frame);
            const uint32_t octant = frame.current ^ mirror_;
            if (((frame.children >> octant) & 1u) != 0 && child_exit > range.t_min) {
                if (t > range.t_max) return;
                ++hit.steps;
                const int child_level = level - 1;
                const bool opaque = child_level <= lod.fixed_level ||
                                    static_cast<double>(1 << child_level) <= lod.cone * t;
                if (opaque && t >= range.t_min) {
                    if (passed != nullptr && !*passed) finish(frame, level, octant, t, *passed);
                    if (passed == nullptr || child_level == 0) {
                        finish(frame, level, octant, t, hit);
                        if (rule == nullptr || child_level == 0 || rule->stops(hit)) return;
                        hit = Hit{.steps = hit.steps};
                    }
                }
                if (child_level > 0) {
                    push_child(frame, level, octant, t, child_exit);
                    level = child_level;
                    continue;
                }
            }
            t = child_exit;
            while (t >= frames_[static_cast<size_t>(level)].t_exit) {
                if (++level > start_level_) return;
            }
            pass_planes(frames_[static_cast<size_t>(level)], t);
        }
    }

    double t_of_plane(int axis, int plane) const {
        return (static_cast<double>(plane) - origin_[axis]) * inverse_[axis];
    }
    double t_enter_of_axis(const IVec3& corner, int edge, int axis) const {
        const bool mirrored = ((mirror_ >> axis) & 1u) != 0;
        return t_of_plane(axis, corner[axis] + (mirrored ? edge : 0));
    }
    double t_enter_of(const IVec3& corner, int edge) const {
        return std::max({t_enter_of_axis(corner, edge, 0), t_enter_of_axis(corner, edge, 1),
                         t_enter_of_axis(corner, edge, 2)});
    }
    double t_exit_of(const IVec3& corner, int edge) const {
        double t = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            const bool mirrored = ((mirror_ >> axis) & 1u) != 0;
            t = std::min(t, t_of_plane(axis, corner[axis] + (mirrored ? 0 : edge)));
        }
        return t;
    }

    /// Leaving the current child: through a mid-plane still ahead, or out of the node.
    static double exit_of_current(const Frame& frame) {
        double t = frame.t_exit;
        for (int axis = 0; axis < 3; ++axis) {
            if (((frame.current >> axis) & 1u) == 0) t = std::min(t, frame.t_mid[axis]);
        }
        return t;
    }

    /// Moves on to the child that the ray enters at t; planes met at once are passed at once.
    static void pass_planes(Frame& frame, double t) {
        for (int axis = 0; axis < 3; ++axis) {
            if (frame.t_mid[axis] <= t) frame.current |= 1u << axis;
        }
    }

    void open(Frame& frame, int level, double t) const {
        const int half = 1 << (level - 1);
        for (int axis = 0; axis < 3; ++axis) {
            frame.t_mid[axis] = t_of_plane(axis, frame.corner[axis] + half);
        }
        frame.current = 0;
        pass_planes(frame, t);
    }

    void push_root(double t, double t_exit) {
        Frame& frame = frames_[static_cast<size_t>(depth_)];
        frame.t_exit = t_exit;
        frame.corner = IVec3(0);
        frame.node = 0;
        frame.octant = 0;
        const uint64_t mask = nodes_[0].mask;
        frame.children =
            depth_ % 2 == 0 ? nonzero_bytes(mask) : static_cast<uint32_t>(mask & 0xFFu);
        open(frame, depth_, t);
    }

    void push_start(const StartNode& start, double t, double t_exit) {
        start_level_ = start.level;
        above_start_ = &start.path;
        Frame& frame = frames_[static_cast<size_t>(start.level)];
        frame.t_exit = t_exit;
        frame.corner = start.corner;
        frame.node = start.path[static_cast<size_t>((start.level - 1) / 2)];
        const uint64_t mask = nodes_[frame.node].mask;
        if (start.level % 2 == 0) {
            frame.octant = 0;
            frame.children = nonzero_bytes(mask);
        } else {
            frame.octant = octant_of(start.corner, start.level);
            frame.children = static_cast<uint32_t>((mask >> (8 * frame.octant)) & 0xFFu);
        }
        open(frame, start.level, t);
    }

    void push_child(const Frame& parent, int level, uint32_t octant, double t, double t_exit) {
        const int child_level = level - 1;
        Frame& frame = frames_[static_cast<size_t>(child_level)];
        const int edge = 1 << child_level;
        for (int axis = 0; axis < 3; ++axis) {
            frame.corner[axis] = parent.corner[axis] + (((octant >> axis) & 1u) != 0 ? edge : 0);
        }
        frame.t_exit = t_exit;
        if (level % 2 == 0) {
            frame.node = parent.node;
            frame.octant = octant;
            frame.children =
                static_cast<uint32_t>((nodes_[parent.node].mask >> (8 * octant)) & 0xFFu);
        } else {
            frame.node = child_node(parent, octant);
            frame.octant = 0;
            frame.children = nonzero_bytes(nodes_[frame.node].mask);
        }
        open(frame, child_level, t);
    }

    /// All of a hit but the way there.
    void describe(const IVec3& corner, int level, double t, Hit& hit) const {
        hit.t = t;
        hit.point = origin_ + t * direction_;
        hit.level = level;
        hit.corner = corner;
        const int edge = 1 << level;
        int entry_axis = 0;
        double latest = t_enter_of_axis(hit.corner, edge, 0);
        for (int axis = 1; axis < 3; ++axis) {
            const double at = t_enter_of_axis(hit.corner, edge, axis);
            if (at > latest) {
                latest = at;
                entry_axis = axis;
            }
        }
        const uint32_t backward = (mirror_ >> entry_axis) & 1u;  // heading for −axis
        hit.entry_face = static_cast<CubeFace>(2 * entry_axis + (backward != 0 ? 0 : 1));
    }

    void finish(const Frame& frame, int level, uint32_t octant, double t, Hit& hit) const {
        const int edge = 1 << (level - 1);
        IVec3 corner = frame.corner;
        for (int axis = 0; axis < 3; ++axis) {
            if (((octant >> axis) & 1u) != 0) corner[axis] += edge;
        }
        describe(corner, level - 1, t, hit);
        if (above_start_ != nullptr) hit.path = *above_start_;
        // Node level k is octree level 2k + 2; frames 2k + 2 and 2k + 1 stand in the same node.
        for (int k = (depth_ - 1) / 2; k >= 0 && 2 * k + 2 > hit.level; --k) {
            if (2 * k + 1 > start_level_) continue;
            const int holder = std::min(2 * k + 2, start_level_);
            hit.path[static_cast<size_t>(k)] = frames_[static_cast<size_t>(holder)].node;
        }
        if (hit.level >= 2 && hit.level % 2 == 0) {
            hit.path[static_cast<size_t>(hit.level / 2 - 1)] = child_node(frame, octant);
        }
    }

    uint32_t child_node(const Frame& octant_frame, uint32_t cell) const {
        const VoxelNode& node = nodes_[octant_frame.node];
        return node.first_child + rank_below(node.mask, 8 * octant_frame.octant + cell);
    }

    std::span<const VoxelNode> nodes_;
    Vec3 origin_;
    Vec3 direction_;
    Vec3 inverse_{0.0};
    uint32_t mirror_ = 0;
    int depth_;
    int start_level_ = 0;
    const std::array<uint32_t, kMaxNodeLevels>* above_start_ = nullptr;
    std::array<Frame, kMaxDepth + 1> frames_;  // by octree level; set as they are entered
};

bool can_be_traced(const VoxelTree& tree, const Ray& ray) {
    return !tree.empty() && is_finite(ray.origin) && is_finite(ray.direction) &&
           ray.direction != Vec3(0.0);
}

Hit trace_with(const VoxelTree& tree, const Ray& ray, const LevelOfDetail& lod,
               const TraceRange& range, StopRule* rule) {
    if (!can_be_traced(tree, ray)) return {};
    return Traversal(tree, ray).run(lod, range, rule);
}

}  // namespace

Hit trace(const VoxelTree& tree, const Ray& ray, const LevelOfDetail& lod,
          const TraceRange& range) {
    return trace_with(tree, ray, lod, range, nullptr);
}

Hit trace(const VoxelTree& tree, const Ray& ray, const LevelOfDetail& lod, const TraceRange& range,
          StopRule& rule) {
    return trace_with(tree, ray, lod, range, &rule);
}

HitBehind trace_through(const VoxelTree& tree, const Ray& ray, const LevelOfDetail& lod,
                        const TraceRange& range) {
    HitBehind hit;
    if (!can_be_traced(tree, ray)) return hit;
    hit.leaf = Traversal(tree, ray).run(lod, range, nullptr, &hit.node);
    hit.node.steps = hit.leaf.steps;
    return hit;
}

HitBehind trace_through(const VoxelTree& tree, const StartList& from, const Ray& ray,
                        const LevelOfDetail& lod, const TraceRange& range) {
    HitBehind hit;
    if (!can_be_traced(tree, ray)) return hit;
    hit.leaf = Traversal(tree, ray).run_from(from, lod, range, &hit.node);
    hit.node.steps = hit.leaf.steps;
    return hit;
}

Hit trace(const VoxelTree& tree, const StartList& from, const Ray& ray, const TraceRange& range) {
    if (!can_be_traced(tree, ray)) return {};
    return Traversal(tree, ray).run_from(from, {}, range, nullptr);
}

ColorIndex color_index(const VoxelTree& tree, const Hit& hit, int level) {
    if (level >= 2 && level % 2 == 0) {
        return {ColorIndex::Array::kNodes, hit.path[static_cast<size_t>(level / 2 - 1)]};
    }
    const VoxelNode& node = tree.nodes()[hit.path[static_cast<size_t>(level / 2)]];
    const uint32_t octant = octant_of(hit.corner, level | 1);
    if (level == 0) {
        const uint32_t cell = octant_of(hit.corner, 0);
        return {ColorIndex::Array::kVoxels,
                node.first_child + rank_below(node.mask, 8 * octant + cell)};
    }
    return {ColorIndex::Array::kOctants,
            node.octant_base + rank_below(nonzero_bytes(node.mask), octant)};
}

ColorRange child_colors(const VoxelTree& tree, const Hit& hit) {
    if (hit.level % 2 == 0) {
        const VoxelNode& node = tree.nodes()[hit.path[static_cast<size_t>(hit.level / 2 - 1)]];
        return {{ColorIndex::Array::kOctants, node.octant_base},
                static_cast<uint32_t>(std::popcount(nonzero_bytes(node.mask)))};
    }
    const VoxelNode& node = tree.nodes()[hit.path[static_cast<size_t>(hit.level / 2)]];
    const uint32_t octant = octant_of(hit.corner, hit.level);
    return {{hit.level == 1 ? ColorIndex::Array::kVoxels : ColorIndex::Array::kNodes,
             node.first_child + rank_below(node.mask, 8 * octant)},
            static_cast<uint32_t>(std::popcount((node.mask >> (8 * octant)) & 0xFFu))};
}

ChildMasks child_masks(const VoxelTree& tree, const Hit& hit) {
    ChildMasks masks;
    if (hit.level == 0) return masks;
    if (hit.level % 2 == 0) {
        const VoxelNode& node = tree.nodes()[hit.path[static_cast<size_t>(hit.level / 2 - 1)]];
        masks.own = static_cast<uint8_t>(nonzero_bytes(node.mask));
        for (uint64_t rest = node.mask; rest != 0; rest >>= 8) {
            if ((rest & 0xFFu) != 0) masks.children[masks.child_count++] = rest & 0xFFu;
        }
        return masks;
    }
    const VoxelNode& node = tree.nodes()[hit.path[static_cast<size_t>(hit.level / 2)]];
    const uint32_t octant = octant_of(hit.corner, hit.level);
    masks.own = static_cast<uint8_t>((node.mask >> (8 * octant)) & 0xFFu);
    masks.child_count = static_cast<uint8_t>(std::popcount(masks.own));
    if (hit.level == 1) {
        masks.children.fill(255);
        return masks;
    }
    const uint32_t first = node.first_child + rank_below(node.mask, 8 * octant);
    for (uint32_t i = 0; i < masks.child_count; ++i) {
        masks.children[i] = static_cast<uint8_t>(nonzero_bytes(tree.nodes()[first + i].mask));
    }
    return masks;
}

}  // namespace probebake
