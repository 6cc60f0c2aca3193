#include "voxels/color_pyramid.h"

#include <tbb/parallel_for.h>

#include <bit>
#include <utility>

#include "voxels/voxel_tree.h"

namespace probebake {
namespace {

/// Mean colours of the nodes and octants of one node level, from its cells' colours.
template <class CellColor>
std::vector<Rgb> average_level(const VoxelTree& tree, int k, CellColor cell_color,
                               ColorLevels& out) {
    const std::span<const VoxelNode> level = tree.node_level(k);
    const uint64_t begin = tree.level_begin(k);
    std::vector<Rgb> means(level.size());
    tbb::parallel_for(size_t{0}, level.size(), [&](size_t i) {
        const VoxelNode& node = level[i];
        uint32_t cell = node.first_child;
        uint32_t octant = node.octant_base;
        Rgb node_sum(0.0f);
        for (uint64_t rest = node.mask, b = 0; b < 8; ++b, rest >>= 8) {
            const int children = std::popcount(rest & 0xFFu);
            if (children == 0) continue;
            Rgb sum(0.0f);
            for (int c = 0; c < children; ++c) sum += cell_color(cell++);
            const Rgb mean = sum / static_cast<float>(children);
            out.octants[octant++] = pack_rgb(mean);
            node_sum += mean;
        }
        const int octants = static_cast<int>(octant - node.octant_base);
        means[i] = octants > 0 ? node_sum / static_cast<float>(octants) : Rgb(0.0f);
        out.nodes[begin + i] = pack_rgb(means[i]);
    });
    return means;
}

}  // namespace

ColorLevels average_up(const VoxelTree& tree, std::vector<PackedRgb> voxels, float scale) {
    ColorLevels out;
    out.scale = scale;
    out.voxels = std::move(voxels);
    out.octants.resize(tree.octant_count());
    out.nodes.resize(tree.nodes().size());
    std::vector<Rgb> below = average_level(
        tree, 0, [&](uint32_t i) { return unpack_rgb(out.voxels[i]); }, out);
    for (int k = 1; k < tree.node_levels(); ++k) {
        const auto first = static_cast<uint32_t>(tree.level_begin(k - 1));
        below = average_level(
            tree, k, [&](uint32_t i) { return below[i - first]; }, out);
    }
    return out;
}

}  // namespace probebake
