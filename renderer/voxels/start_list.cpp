#include "voxels/start_list.h"

#include <algorithm>
#include <limits>

namespace probebake {
namespace {

/// A node is split while it is wider than so many beams.
constexpr double kBeamsPerNode = 1.0;
/// Nodes of a list, beyond which the others stay unsplit.
constexpr size_t kManyNodes = 64;
/// Nodes of this level are not split: below them a list costs more than it saves.
constexpr int kFinestLevel = 2;
/// How far outside of the pyramid a node still counts as met, per distance: far above what
/// directions are rounded by.
constexpr double kMargin = 1e-9;

/// The planes of the sides and the one behind: conservative tests of boxes.
class BeamTest {
  public:
    explicit BeamTest(const Beam& beam) : beam_(beam) {
        Vec3 middle(0.0);
        for (const Vec3& edge : beam.edges) middle += edge;
        for (size_t i = 0; i < 4; ++i) {
            const Vec3 normal = glm::normalize(glm::cross(beam.edges[i], beam.edges[(i + 1) % 4]));
            inward_[i] = glm::dot(normal, middle) < 0.0 ? -normal : normal;
        }
        inward_[4] = glm::normalize(middle);
    }

    bool meets(const IVec3& corner, int edge) const {
        const Vec3 low = Vec3(corner) - beam_.origin;
        const Vec3 high = low + Vec3(edge);
        const Vec3 far = glm::max(glm::abs(low), glm::abs(high));
        const double margin = kMargin * (far.x + far.y + far.z + 1.0);
        for (const Vec3& inward : inward_) {
            double most = 0.0;
            for (int axis = 0; axis < 3; ++axis) {
                most += inward[axis] * (inward[axis] > 0.0 ? high[axis] : low[axis]);
            }
            if (most < -margin) return false;
        }
        return true;
    }

    /// Split: wide as seen from the beam's origin, and opaque to no ray.
    bool splits(const IVec3& corner, int edge) const {
        const Vec3 low = Vec3(corner) - beam_.origin;
        const Vec3 high = low + Vec3(edge);
        const Vec3 nearest = glm::max(Vec3(0.0), glm::max(low, -high));
        return edge > kBeamsPerNode * beam_.width * glm::length(nearest) &&
               edge > beam_.cone * far_distance(low, high);
    }

  private:
    static double far_distance(const Vec3& low, const Vec3& high) {
        return glm::length(glm::max(glm::abs(low), glm::abs(high)));
    }

    const Beam& beam_;
    std::array<Vec3, 5> inward_;
};

class ListBuilder {
  public:
    ListBuilder(const VoxelTree& tree, const Beam& beam)
        : tree_(tree), origin_(beam.origin), test_(beam) {
        list_.nodes.reserve(kManyNodes / 2);
    }

    void add_root() {
        path_.fill(0);
        add({0, 0, 0}, tree_.depth());
    }
    void add(const StartNode& node) {
        path_ = node.path;
        add(node.corner, node.level);
    }
    StartList take() { return std::move(list_); }

  private:
    /// A node whose ancestors are in path_.
    void add(const IVec3& corner, int level) {
        const int edge = 1 << level;
        if (!test_.meets(corner, edge)) return;
        if (level < tree_.depth()) ++list_.steps;
        if (level > kFinestLevel && list_.nodes.size() < kManyNodes && test_.splits(corner, edge)) {
            add_children(corner, level);
        } else {
            list_.nodes.push_back({.low = Vec3(corner),
                                   .high = Vec3(corner + edge),
                                   .corner = corner,
                                   .level = level,
                                   .path = path_});
        }
    }

    void add_children(const IVec3& corner, int level) {
        const int child_level = level - 1;
        const int half = 1 << child_level;
        const VoxelNode& holder = tree_.nodes()[path_[static_cast<size_t>((level - 1) / 2)]];
        const uint32_t octant = level % 2 == 0 ? 0 : octant_of(corner, level);
        const uint32_t children =
            level % 2 == 0 ? nonzero_bytes(holder.mask)
                           : static_cast<uint32_t>((holder.mask >> (8 * octant)) & 0xFFu);
        uint32_t nearest = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (origin_[axis] >= corner[axis] + half) nearest |= 1u << axis;
        }
        for (uint32_t i = 0; i < 8; ++i) {
            const uint32_t child = nearest ^ i;
            if (((children >> child) & 1u) == 0) continue;
            IVec3 at = corner;
            for (int axis = 0; axis < 3; ++axis) {
                if (((child >> axis) & 1u) != 0) at[axis] += half;
            }
            if (level % 2 != 0) {
                path_[static_cast<size_t>(child_level / 2 - 1)] =
                    holder.first_child + rank_below(holder.mask, 8 * octant + child);
            }
            add(at, child_level);
        }
    }

    const VoxelTree& tree_;
    Vec3 origin_;
    BeamTest test_;
    std::array<uint32_t, kMaxNodeLevels> path_{};
    StartList list_;
};

}  // namespace

StartList start_list(const VoxelTree& tree, const Beam& beam) {
    ListBuilder builder(tree, beam);
    if (!tree.empty()) builder.add_root();
    return builder.take();
}

StartList start_list(const VoxelTree& tree, const Beam& beam, const StartList& from) {
    ListBuilder builder(tree, beam);
    for (const StartNode& node : from.nodes) builder.add(node);
    return builder.take();
}

}  // namespace probebake
