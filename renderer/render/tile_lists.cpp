#include "render/tile_lists.h"

#include <algorithm>

namespace probebake {

PixelRect TileLists::pixels(const View& view, int tile) const {
    const int x0 = tile % across_ * kSide_px;
    const int y0 = tile / across_ * kSide_px;
    return {x0, y0, std::min(x0 + kSide_px, view.width_px) - 1,
            std::min(y0 + kSide_px, view.height_px) - 1};
}

uint64_t TileLists::make(const VoxelTree& tree, const View& view, int tile) {
    if (lists_.empty()) return 0;
    StartList& list = lists_[static_cast<size_t>(tile)];
    list = start_list(tree, pixel_beam(view, pixels(view, tile), 1.0));
    return list.steps;
}

}  // namespace probebake
