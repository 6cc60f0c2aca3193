// FaceBlock: the voxels of one 64-ary node of the second level (16³; 4³ in the smallest trees) with
// the layer of voxels around them, unpacked, so that neighbours are a lookup away.
#pragma once

#include <vector>

#include "math/cube_face.h"
#include "voxels/voxel_tree.h"

namespace probebake {

/// The node level of the blocks of a tree.
inline int block_level(const VoxelTree& tree) { return std::min(1, tree.node_levels() - 1); }

struct BlockVoxel {
    IVec3 at{0};          // from the block's corner
    uint32_t index = 0;   // of the voxel in the tree
    uint8_t exposed = 0;  // bit f: the voxel beside face f is empty
};

class FaceBlock {
  public:
    /// `code`: the Morton code of the node at its level.
    FaceBlock(const VoxelTree& tree, uint32_t node, uint64_t code);

    const IVec3& corner() const { return corner_; }
    int edge() const { return edge_; }
    uint32_t node() const { return node_; }
    /// In Morton order, so that the voxels of any octree node are neighbours in the list.
    const std::vector<BlockVoxel>& voxels() const { return voxels_; }
    /// Coordinates from −1 to edge().
    bool solid(const IVec3& at) const { return solid_[index(at)] != 0; }

  private:
    size_t index(const IVec3& at) const {
        const int side = edge_ + 2;
        return static_cast<size_t>(((at.z + 1) * side + at.y + 1) * side + at.x + 1);
    }

    uint32_t node_;
    IVec3 corner_;
    int edge_;
    std::vector<uint8_t> solid_;
    std::vector<BlockVoxel> voxels_;
};

/// The voxel beside face f.
inline IVec3 beside(IVec3 at, int face) {
    at[face / 2] += face % 2 == 0 ? 1 : -1;
    return at;
}

/// Morton codes of all nodes of node level k, in the tree's order.
std::vector<uint64_t> node_codes(const VoxelTree& tree, int k);

}  // namespace probebake
