#include "light/voxel_values.h"

#include <tbb/parallel_for.h>

namespace probebake {
namespace {

/// A mean of some values.
struct Mean {
    Rgb sum{0.0f};
    int count = 0;

    void add(const Rgb& value) {
        sum += value;
        ++count;
    }
    PackedRgb packed() const {
        return count > 0 ? pack_rgb(sum / static_cast<float>(count)) : PackedRgb{0};
    }
};

PackedRgb mean_of_faces(const FaceLevel& voxels, size_t voxel) {
    Mean mean;
    for (int face = 0; face < kFaceCount; ++face) {
        if (!voxels.exposes(voxel, face)) continue;
        mean.add(unpack_rgb(voxels.values[voxels.index_of(voxel, face)]));
    }
    return mean.packed();
}

}  // namespace

ColorLevels one_value_per_voxel(const VoxelTree& tree, const FaceColors& faces) {
    ColorLevels out;
    out.scale = faces.scale;
    out.voxels.resize(tree.voxel_count());
    out.octants.resize(tree.octant_count());
    out.nodes.resize(tree.nodes().size());
    tbb::parallel_for(size_t{0}, out.voxels.size(),
                      [&](size_t i) { out.voxels[i] = mean_of_faces(faces.voxels, i); });
    for (int k = 0; k < tree.node_levels(); ++k) {
        const std::vector<PackedRgb>& below = k == 0 ? out.voxels : out.nodes;
        const FaceLevel& faces_below = k == 0 ? faces.voxels : faces.nodes;
        const std::span<const VoxelNode> level = tree.node_level(k);
        const uint64_t begin = tree.level_begin(k);
        tbb::parallel_for(size_t{0}, level.size(), [&](size_t i) {
            uint32_t child = level[i].first_child;
            uint32_t octant = level[i].octant_base;
            Mean of_node;
            for (uint64_t rest = level[i].mask; rest != 0; rest >>= 8) {
                const int children = std::popcount(rest & 0xFFu);
                if (children == 0) continue;
                Mean of_octant;
                for (int c = 0; c < children; ++c, ++child) {
                    if (faces_below.exposed[child] != 0) of_octant.add(unpack_rgb(below[child]));
                }
                out.octants[octant] = of_octant.packed();
                if (of_octant.count > 0) of_node.add(unpack_rgb(out.octants[octant]));
                ++octant;
            }
            out.nodes[begin + i] = of_node.packed();
        });
    }
    return out;
}

}  // namespace probebake
