// ItemOctree: an octree over items that are known by their boxes.
//
// A node with more than most_items of them above the maximum depth is split; an item goes into
// every octant that its box touches (octants closed on both sides), so that a leaf names every item
// that may be met in it. Which items those are is the caller's: they are numbers here.
#pragma once

#include <span>
#include <vector>

#include "octree/octree.h"
#include "octree/split_planes.h"

namespace probebake {

struct ItemOctreeParams {
    int max_depth = 7;  // 0..kMaxOctreeDepth
    uint32_t most_items = 1;
    SplitPlanes planes = SplitPlanes::kCenter;
    /// No node is split once the leaves name more items than this (4 bytes each).
    uint64_t most_references = uint64_t{1} << 28;
};

struct ItemOctreeCounts {       // by Havran 1999's names
    uint64_t inner = 0;         // N_IN
    uint64_t leaves = 0;        // N_V
    uint64_t empty_leaves = 0;  // N_EV
    uint64_t references = 0;    // N_OIV

    bool operator==(const ItemOctreeCounts&) const = default;
};

class ItemOctree {
  public:
    ItemOctree() = default;
    /// Throws std::invalid_argument for parameters out of range and for boxes that are not finite.
    ItemOctree(const Box& root, std::span<const Box> item_boxes, const ItemOctreeParams& params);

    const Octree& tree() const { return tree_; }
    std::span<const uint32_t> items(uint32_t leaf) const {
        return std::span(items_).subspan(leaf_begin_[leaf],
                                         leaf_begin_[leaf + 1] - leaf_begin_[leaf]);
    }
    const ItemOctreeCounts& counts() const { return counts_; }
    uint64_t memory_bytes() const;

  private:
    Octree tree_;
    std::vector<uint32_t> items_;
    std::vector<uint32_t> leaf_begin_{0};
    ItemOctreeCounts counts_;
};

}  // namespace probebake
