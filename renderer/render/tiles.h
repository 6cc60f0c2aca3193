// Work in tiles of rows, in parallel, its costs added up in order.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "io/cancel.h"
#include "render/cost_stats.h"

namespace probebake {

/// Rows of a tile: short enough that a cancelled render stops within milliseconds.
inline constexpr int kTileRows = 8;

/// Calls work(row, stats) for all rows on the calling arena. Throws Cancelled.
template <class Work>
CostStats for_each_row(int rows, const CancelToken& cancel, Work work) {
    const int tiles = (rows + kTileRows - 1) / kTileRows;
    std::vector<CostStats> stats(static_cast<size_t>(tiles));
    tbb::parallel_for(0, tiles, [&](int tile) {
        if (cancel.cancelled()) return;
        const auto start = std::chrono::steady_clock::now();
        CostStats& mine = stats[static_cast<size_t>(tile)];
        const int end = std::min(rows, (tile + 1) * kTileRows);
        for (int row = tile * kTileRows; row < end; ++row) work(row, mine);
        mine.seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    });
    cancel.throw_if_cancelled();
    CostStats total;
    for (const CostStats& tile : stats) total += tile;
    return total;
}

}  // namespace probebake
