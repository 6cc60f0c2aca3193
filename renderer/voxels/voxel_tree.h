// VoxelTree: a 64-ary tree of voxels that is an octree, two octree levels to a node.
//
// Levels are octree levels: level l has nodes of edge 2^l voxels; level 0 are the voxels, level
// `depth` is the root of the world, [0, 2^depth)³. One 16-byte node spans three of them:
//
//   level 2k+2   the node itself                          colors.nodes[node index]
//   level 2k+1   its up to 8 octants, byte b of the mask  colors.octants[octant_base + rank]
//   level 2k     its up to 64 cells, bit 8b + c           nodes[first_child + rank], or, where
//                                                         k = 0, voxel first_child + rank
//
// The mask is in Morton order, so that byte b IS the 2×2×2 child mask of octant b (bit = x+2y+4z)
// and the nonzero bytes are the node's own child mask: what the error table is indexed by.
// Nodes are stored level by level from the root, children contiguous and in Morton order. Where
// `depth` is odd, the root node holds the world in its octant 0.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "math/vec.h"
#include "voxels/color_pyramid.h"
#include "voxels/voxel_cloud.h"

namespace probebake {

inline constexpr int kMaxDepth = 16;
inline constexpr int kMaxNodeLevels = kMaxDepth / 2;

struct VoxelNode {
    uint64_t mask = 0;         // bit 8·octant + cell
    uint32_t first_child = 0;  // index of the first child node, or of the first voxel
    uint32_t octant_base = 0;  // index of the node's first octant among all octants

    bool operator==(const VoxelNode&) const = default;
};
static_assert(sizeof(VoxelNode) == 16);

/// Bit b of the result is set when byte b of the mask is nonzero.
constexpr uint32_t nonzero_bytes(uint64_t mask) {
    mask |= mask >> 4;
    mask |= mask >> 2;
    mask |= mask >> 1;
    mask &= 0x0101'0101'0101'0101ull;
    return static_cast<uint32_t>((mask * 0x0102'0408'1020'4080ull) >> 56);
}

/// Number of set bits of `mask` below bit `bit`.
constexpr uint32_t rank_below(uint64_t mask, uint32_t bit) {
    return static_cast<uint32_t>(std::popcount(mask & ((uint64_t{1} << bit) - 1)));
}

/// Which octant of its parent the node of octree level `level` at `position` is.
inline uint32_t octant_of(const IVec3& position, int level) {
    return static_cast<uint32_t>(((position.x >> level) & 1) | (((position.y >> level) & 1) << 1) |
                                 (((position.z >> level) & 1) << 2));
}

/// What a build cost.
struct BuildStats {
    double sort_seconds = 0.0;
    double tree_seconds = 0.0;
    double color_seconds = 0.0;
    uint64_t duplicates = 0;  // voxels that lost their position to another
    uint64_t peak_bytes = 0;  // largest sum of the build's own buffers, the input included
};

class VoxelTree {
  public:
    /// Builds from any list, in parallel on the calling arena; consumes it. An empty list gives a
    /// tree without voxels. Throws std::invalid_argument for a voxel outside [0, 2^depth)³, for a
    /// depth outside 2..16 and beyond 2^32 − 1 voxels.
    static VoxelTree build(VoxelCloud cloud, BuildStats* stats = nullptr);

    VoxelTree() = default;
    VoxelTree(int depth, std::vector<VoxelNode> nodes, std::vector<uint64_t> level_begin,
              uint64_t voxel_count, uint64_t octant_count);

    /// log2 of the world's side in voxels, 2..16.
    int depth() const { return depth_; }
    /// Levels of 64-ary nodes; node level k (0 = nodes of 4³ voxels) is octree level 2k + 2.
    int node_levels() const { return static_cast<int>(level_begin_.size()) - 1; }
    bool empty() const { return voxel_count_ == 0; }
    std::span<const VoxelNode> nodes() const { return nodes_; }
    /// Nodes of node level k, from the lowest Morton code.
    std::span<const VoxelNode> node_level(int k) const;
    /// Index of the first node of node level k.
    uint64_t level_begin(int k) const {
        return level_begin_[static_cast<size_t>(node_levels() - 1 - k)];
    }

    /// First node of every level from the root's down, and the end.
    const std::vector<uint64_t>& level_begins() const { return level_begin_; }

    uint64_t voxel_count() const { return voxel_count_; }
    uint64_t octant_count() const { return octant_count_; }
    /// Non-empty octree nodes at each level 0..depth, voxels and root included.
    std::vector<uint64_t> octree_nodes_per_level() const;
    /// Their sum: "octree nodes" of Müller 2020, table 4.1.
    uint64_t octree_node_count() const;
    /// Bytes of the nodes and of the colours.
    uint64_t node_bytes() const { return nodes_.size() * sizeof(VoxelNode); }
    uint64_t memory_bytes() const { return node_bytes() + colors_.memory_bytes(); }

    bool occupied(const IVec3& position) const;
    /// The voxel's index in ColorPyramid order, or no value where it is empty.
    std::optional<uint32_t> find_voxel(const IVec3& position) const;
    /// Calls visit(position) for every voxel in Morton order, which is the order of their colours.
    template <class Visit>
    void for_each_voxel(Visit visit) const {
        if (!empty()) visit_node(node_levels() - 1, 0, 0, visit);
    }

    const ColorPyramid& colors() const { return colors_; }
    void set_colors(ColorPyramid colors) { colors_ = std::move(colors); }

    bool operator==(const VoxelTree&) const = default;

  private:
    /// `code`: the Morton code of the node at its own level.
    template <class Visit>
    void visit_node(int k, uint32_t index, uint64_t code, Visit& visit) const {
        const VoxelNode& node = nodes_[index];
        uint32_t child = node.first_child;
        for (uint64_t rest = node.mask; rest != 0; rest &= rest - 1, ++child) {
            const uint64_t cell = code << 6 | static_cast<uint64_t>(std::countr_zero(rest));
            if (k == 0) {
                visit(morton_decode(cell));
            } else {
                visit_node(k - 1, child, cell, visit);
            }
        }
    }

    int depth_ = 2;
    std::vector<VoxelNode> nodes_;
    std::vector<uint64_t> level_begin_{0};  // from the root's level down, plus the end
    uint64_t voxel_count_ = 0;
    uint64_t octant_count_ = 0;
    ColorPyramid colors_;
};

}  // namespace probebake
