#include "voxels/tree_builder.h"

#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace probebake {
namespace {

/// Indices of nodes and voxels are 32 bits wide.
constexpr uint64_t kMostVoxels = std::numeric_limits<uint32_t>::max();

}  // namespace

TreeBuilder::TreeBuilder(int depth) : depth_(depth) {
    if (depth < 2 || depth > kMaxDepth) {
        throw std::invalid_argument("the depth of a world is 2 to 16, not " +
                                    std::to_string(depth));
    }
    levels_.resize(static_cast<size_t>(depth + 1) / 2);
}

void TreeBuilder::append(std::span<const Voxel> voxels) {
    if (voxels.size() > kMostVoxels - albedo_.size()) {
        throw std::invalid_argument("a voxel tree holds at most 4,294,967,295 voxels, not " +
                                    std::to_string(albedo_.size() + voxels.size()));
    }
    for (const Voxel& voxel : voxels) {
        const uint64_t code = voxel.morton();
        if (code >> (3 * depth_) != 0) {
            const IVec3 p = morton_decode(code);
            throw std::invalid_argument("voxel (" + std::to_string(p.x) + ", " +
                                        std::to_string(p.y) + ", " + std::to_string(p.z) +
                                        ") lies outside the world of 2^" + std::to_string(depth_) +
                                        " voxels per axis");
        }
        if (code < next_code_) throw std::invalid_argument("voxels out of Morton order");
        next_code_ = code + 1;
        add(code);
        albedo_.push_back(voxel.albedo);
        if (voxel.emission != 0 && emission_.empty()) {
            emission_.reserve(albedo_.capacity());
            emission_.resize(albedo_.size() - 1, 0);
        }
        if (voxel.emission != 0 || !emission_.empty()) emission_.push_back(voxel.emission);
    }
}

void TreeBuilder::add(uint64_t code) {
    uint64_t index = albedo_.size();
    for (Level& level : levels_) {
        const uint64_t parent = code >> 6;
        const bool is_new = parent != level.last;
        if (is_new) {
            level.nodes.push_back({.first_child = static_cast<uint32_t>(index)});
            level.last = parent;
        }
        level.nodes.back().mask |= uint64_t{1} << (code & 63u);
        if (!is_new) return;
        index = level.nodes.size() - 1;
        code = parent;
    }
}

uint64_t TreeBuilder::memory_bytes() const {
    uint64_t bytes = (albedo_.capacity() + emission_.capacity()) * sizeof(PackedRgb);
    for (const Level& level : levels_) bytes += level.nodes.capacity() * sizeof(VoxelNode);
    return bytes;
}

/// One array from the root down.
std::vector<VoxelNode> TreeBuilder::joined_levels(std::vector<uint64_t>& level_begin) {
    size_t count = 0;
    for (const Level& level : levels_) count += level.nodes.size();
    std::vector<VoxelNode> nodes;
    nodes.reserve(count);
    level_begin = {0};
    while (!levels_.empty()) {
        std::vector<VoxelNode> level = std::move(levels_.back().nodes);
        levels_.pop_back();
        const auto below = static_cast<uint32_t>(nodes.size() + level.size());
        for (VoxelNode& node : level) {
            if (!levels_.empty()) node.first_child += below;
            nodes.push_back(node);
        }
        level_begin.push_back(nodes.size());
    }
    return nodes;
}

VoxelTree TreeBuilder::finish(float emission_scale) {
    if (albedo_.empty()) levels_.back().nodes.resize(1);
    std::vector<uint64_t> level_begin;
    std::vector<VoxelNode> nodes = joined_levels(level_begin);
    uint64_t octants = 0;
    for (VoxelNode& node : nodes) {
        node.octant_base = static_cast<uint32_t>(octants);
        octants += static_cast<uint64_t>(std::popcount(nonzero_bytes(node.mask)));
    }
    VoxelTree tree(depth_, std::move(nodes), std::move(level_begin), albedo_.size(), octants);
    ColorPyramid colors;
    colors.albedo = average_up(tree, std::move(albedo_), 1.0f);
    if (!emission_.empty()) {
        colors.emission = average_up(tree, std::move(emission_), emission_scale);
    }
    tree.set_colors(std::move(colors));
    return tree;
}

}  // namespace probebake
