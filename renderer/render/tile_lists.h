// The start lists of a view's tiles (voxels/start_list.h): rays of neighbouring pixels begin at the
// same nodes.
#pragma once

#include <vector>

#include "render/pixel.h"
#include "voxels/start_list.h"

namespace probebake {

/// Squares of 8 × 8 pixels, row by row, the last of a row or column cut where the view ends.
class TileLists {
  public:
    static constexpr int kSide_px = 8;

    /// Without start lists until they are made; without `enabled` they never are.
    TileLists(const View& view, bool enabled)
        : across_((view.width_px + kSide_px - 1) / kSide_px),
          down_((view.height_px + kSide_px - 1) / kSide_px),
          lists_(enabled ? static_cast<size_t>(across_ * down_) : 0) {}

    int tiles() const { return across_ * down_; }
    PixelRect pixels(const View& view, int tile) const;
    /// Makes the list of a tile and returns its steps. Different tiles at the same time.
    uint64_t make(const VoxelTree& tree, const View& view, int tile);
    /// Of the tile that holds a pixel; null without lists.
    const StartList* at(int x, int y) const {
        if (lists_.empty()) return nullptr;
        return &lists_[static_cast<size_t>(y / kSide_px * across_ + x / kSide_px)];
    }

  private:
    int across_;
    int down_;
    std::vector<StartList> lists_;
};

}  // namespace probebake
