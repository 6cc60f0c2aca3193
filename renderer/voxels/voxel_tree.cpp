#include "voxels/voxel_tree.h"

#include <numeric>
#include <utility>

namespace probebake {

VoxelTree::VoxelTree(int depth, std::vector<VoxelNode> nodes, std::vector<uint64_t> level_begin,
                     uint64_t voxel_count, uint64_t octant_count)
    : depth_(depth),
      nodes_(std::move(nodes)),
      level_begin_(std::move(level_begin)),
      voxel_count_(voxel_count),
      octant_count_(octant_count) {}

std::span<const VoxelNode> VoxelTree::node_level(int k) const {
    const uint64_t begin = level_begin(k);
    const uint64_t end = level_begin_[static_cast<size_t>(node_levels() - k)];
    return nodes().subspan(begin, end - begin);
}

std::vector<uint64_t> VoxelTree::octree_nodes_per_level() const {
    std::vector<uint64_t> counts(static_cast<size_t>(depth_) + 1, 0);
    if (empty()) return counts;
    counts[0] = voxel_count_;
    for (int k = 0; k < node_levels(); ++k) {
        const std::span<const VoxelNode> level = node_level(k);
        uint64_t octants = 0;
        for (const VoxelNode& node : level) {
            octants += static_cast<uint64_t>(std::popcount(nonzero_bytes(node.mask)));
        }
        counts[static_cast<size_t>(2 * k + 1)] = octants;
        // An odd depth ends at the root node's octant 0.
        if (2 * k + 2 <= depth_) counts[static_cast<size_t>(2 * k + 2)] = level.size();
    }
    return counts;
}

uint64_t VoxelTree::octree_node_count() const {
    const std::vector<uint64_t> counts = octree_nodes_per_level();
    return std::accumulate(counts.begin(), counts.end(), uint64_t{0});
}

std::optional<uint32_t> VoxelTree::find_voxel(const IVec3& position) const {
    const int side = 1 << depth_;
    for (int axis = 0; axis < 3; ++axis) {
        if (position[axis] < 0 || position[axis] >= side) return std::nullopt;
    }
    if (empty()) return std::nullopt;
    const uint64_t code =
        morton_encode(static_cast<uint32_t>(position.x), static_cast<uint32_t>(position.y),
                      static_cast<uint32_t>(position.z));
    uint32_t index = 0;
    for (int k = node_levels() - 1; k >= 0; --k) {
        const VoxelNode& node = nodes_[index];
        const uint32_t bit = static_cast<uint32_t>(code >> (6 * k)) & 63u;
        if (((node.mask >> bit) & 1u) == 0) return std::nullopt;
        index = node.first_child + rank_below(node.mask, bit);
    }
    return index;
}

bool VoxelTree::occupied(const IVec3& position) const { return find_voxel(position).has_value(); }

}  // namespace probebake
