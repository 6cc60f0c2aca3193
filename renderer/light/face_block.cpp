#include "light/face_block.h"

#include <utility>

#include "math/morton.h"

namespace probebake {
namespace {

/// The 4³ voxels that hold a position; all empty outside the world.
uint64_t brick_mask(const VoxelTree& tree, const IVec3& position) {
    for (int axis = 0; axis < 3; ++axis) {
        if (position[axis] < 0 || position[axis] >= 1 << tree.depth()) return 0;
    }
    const uint64_t code =
        morton_encode(static_cast<uint32_t>(position.x), static_cast<uint32_t>(position.y),
                      static_cast<uint32_t>(position.z));
    uint32_t index = 0;
    for (int k = tree.node_levels() - 1; k > 0; --k) {
        const VoxelNode& node = tree.nodes()[index];
        const uint32_t bit = static_cast<uint32_t>(code >> (6 * k)) & 63u;
        if (((node.mask >> bit) & 1u) == 0) return 0;
        index = node.first_child + rank_below(node.mask, bit);
    }
    return tree.nodes()[index].mask;
}

}  // namespace

FaceBlock::FaceBlock(const VoxelTree& tree, uint32_t node, uint64_t code)
    : node_(node), edge_(4 << (2 * block_level(tree))) {
    corner_ = morton_decode(code) * edge_;
    solid_.assign(static_cast<size_t>(edge_ + 2) * static_cast<size_t>(edge_ + 2) *
                      static_cast<size_t>(edge_ + 2),
                  0);
    for (int z = -4; z <= edge_; z += 4) {
        for (int y = -4; y <= edge_; y += 4) {
            for (int x = -4; x <= edge_; x += 4) {
                const IVec3 brick(x, y, z);
                for (uint64_t rest = brick_mask(tree, corner_ + brick); rest != 0;
                     rest &= rest - 1) {
                    const IVec3 at =
                        brick + morton_decode(static_cast<uint64_t>(std::countr_zero(rest)));
                    bool near = true;
                    for (int axis = 0; axis < 3; ++axis) {
                        near = near && at[axis] >= -1 && at[axis] <= edge_;
                    }
                    if (near) solid_[index(at)] = 1;
                }
            }
        }
    }
    const auto add_voxels = [&](const VoxelNode& leaf, const IVec3& brick) {
        uint32_t voxel = leaf.first_child;
        for (uint64_t rest = leaf.mask; rest != 0; rest &= rest - 1, ++voxel) {
            BlockVoxel out;
            out.at = brick + morton_decode(static_cast<uint64_t>(std::countr_zero(rest)));
            out.index = voxel;
            for (int face = 0; face < kFaceCount; ++face) {
                if (!solid(beside(out.at, face))) {
                    out.exposed = static_cast<uint8_t>(out.exposed | 1u << face);
                }
            }
            voxels_.push_back(out);
        }
    };
    const VoxelNode& top = tree.nodes()[node];
    if (edge_ == 4) {
        add_voxels(top, IVec3(0));
        return;
    }
    uint32_t child = top.first_child;
    for (uint64_t rest = top.mask; rest != 0; rest &= rest - 1, ++child) {
        add_voxels(tree.nodes()[child],
                   morton_decode(static_cast<uint64_t>(std::countr_zero(rest))) * 4);
    }
}

std::vector<uint64_t> node_codes(const VoxelTree& tree, int k) {
    std::vector<uint64_t> codes{0};
    for (int level = tree.node_levels() - 1; level > k; --level) {
        const std::span<const VoxelNode> nodes = tree.node_level(level);
        std::vector<uint64_t> below;
        below.reserve(tree.node_level(level - 1).size());
        for (size_t i = 0; i < nodes.size(); ++i) {
            for (uint64_t rest = nodes[i].mask; rest != 0; rest &= rest - 1) {
                below.push_back(codes[i] << 6 | static_cast<uint64_t>(std::countr_zero(rest)));
            }
        }
        codes = std::move(below);
    }
    return codes;
}

}  // namespace probebake
