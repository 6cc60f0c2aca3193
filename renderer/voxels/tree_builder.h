// TreeBuilder: a VoxelTree from voxels that come in Morton order.
//
// What it holds is the tree itself (4 bytes a voxel and colour, 16 a node): whoever makes a world
// block by block in that order never holds all of its voxels as a list (16 bytes each).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "voxels/voxel_tree.h"

namespace probebake {

class TreeBuilder {
  public:
    /// Throws std::invalid_argument for a depth outside 2..16.
    explicit TreeBuilder(int depth);

    /// Room for so many voxels, where their number is known.
    void reserve(uint64_t voxels) { albedo_.reserve(voxels); }

    /// Every Morton code is larger than the one before; `order` counts for nothing. Throws
    /// std::invalid_argument for a code that is not, for a voxel outside [0, 2^depth)³ and beyond
    /// 2^32 − 1 voxels.
    void append(std::span<const Voxel> voxels);

    uint64_t voxel_count() const { return albedo_.size(); }
    /// Of what it holds now.
    uint64_t memory_bytes() const;

    /// The tree, colours averaged upward in parallel on the calling arena; leaves nothing behind.
    VoxelTree finish(float emission_scale);

  private:
    /// Nodes of one level in Morton order; first_child counts from the level below's beginning.
    struct Level {
        std::vector<VoxelNode> nodes;
        uint64_t last = ~uint64_t{0};  // Morton code of the last node, in its own units
    };

    void add(uint64_t code);
    std::vector<VoxelNode> joined_levels(std::vector<uint64_t>& level_begin);

    int depth_;
    std::vector<Level> levels_;  // from the voxels' parents up
    std::vector<PackedRgb> albedo_;
    std::vector<PackedRgb> emission_;  // empty as long as nothing emits
    uint64_t next_code_ = 0;
};

}  // namespace probebake
