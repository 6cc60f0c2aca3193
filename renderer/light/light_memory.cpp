#include "light/light_memory.h"

#include <tbb/parallel_for.h>

#include <bit>
#include <cmath>

#include "light/face_block.h"
#include "light/face_colors.h"

namespace probebake {
namespace {

constexpr size_t kSampledBlocks = 2048;

/// Of one block: exposed faces of its voxels, exposed directions of its nodes above them.
struct Exposed {
    uint64_t faces = 0;
    uint64_t directions = 0;
};

Exposed exposed_in(const FaceBlock& block) {
    Exposed out;
    const std::vector<BlockVoxel>& voxels = block.voxels();
    for (const BlockVoxel& voxel : voxels) {
        out.faces += static_cast<uint64_t>(std::popcount(voxel.exposed));
    }
    for (int level = 1; 1 << level <= block.edge(); ++level) {
        const auto node_of = [&](size_t i) {
            const IVec3& at = voxels[i].at;
            return IVec3(at.x >> level, at.y >> level, at.z >> level);
        };
        for (size_t i = 0; i < voxels.size();) {
            const IVec3 node = node_of(i);
            unsigned all = 0;
            for (; i < voxels.size() && node_of(i) == node; ++i) all |= voxels[i].exposed;
            out.directions += static_cast<uint64_t>(std::popcount(all));
        }
    }
    return out;
}

}  // namespace

uint64_t expected_face_bytes(const VoxelTree& tree) {
    if (tree.empty()) return 0;
    const std::vector<uint64_t> codes = node_codes(tree, block_level(tree));
    const auto first = static_cast<uint32_t>(tree.level_begin(block_level(tree)));
    const size_t count = std::min(codes.size(), kSampledBlocks);
    std::vector<Exposed> sampled(count);
    tbb::parallel_for(size_t{0}, count, [&](size_t i) {
        const size_t block = i * codes.size() / count;
        sampled[i] =
            exposed_in(FaceBlock(tree, first + static_cast<uint32_t>(block), codes[block]));
    });
    Exposed sum;
    for (const Exposed& one : sampled) {
        sum.faces += one.faces;
        sum.directions += one.directions;
    }
    const double scale = static_cast<double>(codes.size()) / static_cast<double>(count);
    const double of_values =
        scale * (static_cast<double>(sum.faces) * sizeof(PackedRgb) +
                 static_cast<double>(sum.directions) * (sizeof(PackedRgb) + sizeof(FaceGroup)));
    // Nodes above the blocks are few and likely to expose all directions.
    const double of_top =
        6.0 * (first + tree.nodes()[first].octant_base) * (sizeof(PackedRgb) + sizeof(FaceGroup));
    // A byte of directions and an eighth of an index each; whether divided, above the voxels.
    const uint64_t above = tree.octant_count() + tree.nodes().size();
    return static_cast<uint64_t>(of_values + of_top) + (tree.voxel_count() + above) * 3 / 2 + above;
}

uint64_t voxel_value_bytes(const VoxelTree& tree) {
    return (tree.voxel_count() + tree.octant_count() + tree.nodes().size()) * sizeof(PackedRgb);
}

}  // namespace probebake
