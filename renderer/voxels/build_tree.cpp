// VoxelTree::build: sort by Morton code, then group 64 neighbours to a node, level by level.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "voxels/voxel_tree.h"

namespace probebake {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Keeps the last of every run of equal Morton codes of the sorted list; returns how many went.
uint64_t drop_duplicates(std::vector<Voxel>& voxels) {
    size_t kept = 0;
    for (size_t i = 0; i < voxels.size(); ++i) {
        const bool last = i + 1 == voxels.size() || voxels[i + 1].morton() != voxels[i].morton();
        if (last) voxels[kept++] = voxels[i];
    }
    const uint64_t dropped = voxels.size() - kept;
    voxels.resize(kept);
    return dropped;
}

/// The nodes of one level and the Morton code of each (in units of the level's cells, / 64).
struct Level {
    std::vector<VoxelNode> nodes;  // first_child relative to the level below
    std::vector<uint64_t> codes;
};

/// Groups sorted, distinct cell codes (code(i), i < count) by their upper bits, 64 to a node.
template <class Code>
Level group_cells(size_t count, Code code) {
    // Chunks start where a node starts, so that each can be counted and filled on its own.
    constexpr size_t kChunk = 1 << 16;
    std::vector<size_t> begins;
    for (size_t at = 0; at < count; at += kChunk) {
        size_t begin = at;
        while (begin > 0 && begin < count && (code(begin) >> 6) == (code(begin - 1) >> 6)) ++begin;
        if (begins.empty() || begin > begins.back()) begins.push_back(begin);
    }
    const size_t chunks = begins.size();
    begins.push_back(count);

    std::vector<size_t> node_begin(chunks + 1, 0);
    tbb::parallel_for(size_t{0}, chunks, [&](size_t c) {
        size_t groups = 0;
        for (size_t i = begins[c]; i < begins[c + 1]; ++i) {
            if (i == begins[c] || (code(i) >> 6) != (code(i - 1) >> 6)) ++groups;
        }
        node_begin[c + 1] = groups;
    });
    for (size_t c = 0; c < chunks; ++c) node_begin[c + 1] += node_begin[c];

    Level level;
    level.nodes.resize(node_begin[chunks]);
    level.codes.resize(node_begin[chunks]);
    tbb::parallel_for(size_t{0}, chunks, [&](size_t c) {
        size_t next = node_begin[c];
        for (size_t i = begins[c]; i < begins[c + 1]; ++i) {
            const uint64_t parent = code(i) >> 6;
            if (i == begins[c] || parent != (code(i - 1) >> 6)) {
                level.codes[next] = parent;
                level.nodes[next].first_child = static_cast<uint32_t>(i);
                ++next;
            }
            level.nodes[next - 1].mask |= uint64_t{1} << (code(i) & 63u);
        }
    });
    return level;
}

/// Node indices and voxel indices are 32 bits wide.
void check_counts(size_t voxels) {
    if (voxels > std::numeric_limits<uint32_t>::max()) {
        throw std::invalid_argument("a voxel tree holds at most 4,294,967,295 voxels, not " +
                                    std::to_string(voxels));
    }
}

}  // namespace

int depth_for_extent(const IVec3& extent) {
    const int largest = std::max({extent.x, extent.y, extent.z});
    if (largest > (1 << kMaxDepth)) {
        throw std::invalid_argument("a world has at most 65536 voxels per axis, not " +
                                    std::to_string(largest));
    }
    int depth = 2;
    while ((1 << depth) < largest) ++depth;
    return depth;
}

VoxelTree VoxelTree::build(VoxelCloud cloud, BuildStats* stats) {
    if (cloud.depth < 2 || cloud.depth > kMaxDepth) {
        throw std::invalid_argument("the depth of a world is 2 to 16, not " +
                                    std::to_string(cloud.depth));
    }
    std::vector<Voxel>& voxels = cloud.voxels;
    check_counts(voxels.size());
    BuildStats measured;
    auto start = Clock::now();
    const uint64_t input_bytes = voxels.capacity() * sizeof(Voxel);

    const auto before = [](const Voxel& a, const Voxel& b) {
        return std::tie(a.key, a.albedo, a.emission) < std::tie(b.key, b.albedo, b.emission);
    };
    tbb::parallel_sort(voxels.begin(), voxels.end(), before);
    if (!voxels.empty() && voxels.back().morton() >> (3 * cloud.depth) != 0) {
        const IVec3 p = morton_decode(voxels.back().morton());
        throw std::invalid_argument("voxel (" + std::to_string(p.x) + ", " + std::to_string(p.y) +
                                    ", " + std::to_string(p.z) + ") lies outside the world of 2^" +
                                    std::to_string(cloud.depth) + " voxels per axis");
    }
    measured.duplicates = drop_duplicates(voxels);
    measured.sort_seconds = seconds_since(start);

    // Levels from the leaves up, then one array from the root down.
    start = Clock::now();
    const int level_count = (cloud.depth + 1) / 2;
    std::vector<Level> levels;
    uint64_t level_bytes = 0;
    for (int k = 0; k < level_count; ++k) {
        if (k == 0) {
            levels.push_back(
                group_cells(voxels.size(), [&](size_t i) { return voxels[i].morton(); }));
        } else {
            const std::vector<uint64_t>& codes = levels.back().codes;
            levels.push_back(group_cells(codes.size(), [&](size_t i) { return codes[i]; }));
        }
        level_bytes += levels.back().nodes.size() * (sizeof(VoxelNode) + sizeof(uint64_t));
    }
    if (voxels.empty()) levels.back().nodes.resize(1);

    std::vector<VoxelNode> nodes;
    std::vector<uint64_t> level_begin{0};
    for (int k = level_count - 1; k >= 0; --k) {
        const std::vector<VoxelNode>& level = levels[static_cast<size_t>(k)].nodes;
        nodes.insert(nodes.end(), level.begin(), level.end());
        level_begin.push_back(nodes.size());
        const auto below = static_cast<uint32_t>(nodes.size());
        for (size_t i = nodes.size() - level.size(); k > 0 && i < nodes.size(); ++i) {
            nodes[i].first_child += below;
        }
    }
    levels.clear();
    uint64_t octants = 0;
    for (VoxelNode& node : nodes) {
        node.octant_base = static_cast<uint32_t>(octants);
        octants += static_cast<uint64_t>(std::popcount(nonzero_bytes(node.mask)));
    }
    const size_t voxel_count = voxels.size();
    VoxelTree tree(cloud.depth, std::move(nodes), std::move(level_begin), voxel_count, octants);
    measured.tree_seconds = seconds_since(start);

    start = Clock::now();
    std::vector<PackedRgb> albedo(voxel_count);
    std::vector<PackedRgb> emission;
    const bool emits =
        std::any_of(voxels.begin(), voxels.end(), [](const Voxel& v) { return v.emission != 0; });
    if (emits) emission.resize(voxel_count);
    for (size_t i = 0; i < voxel_count; ++i) {
        albedo[i] = voxels[i].albedo;
        if (emits) emission[i] = voxels[i].emission;
    }
    std::vector<Voxel>().swap(voxels);
    ColorPyramid colors;
    colors.albedo = average_up(tree, std::move(albedo), 1.0f);
    if (emits) colors.emission = average_up(tree, std::move(emission), cloud.emission_scale);
    tree.set_colors(std::move(colors));
    measured.color_seconds = seconds_since(start);
    // The sorted input with the levels above it, or with the colours copied out of it.
    measured.peak_bytes =
        input_bytes +
        std::max(level_bytes + tree.node_bytes(),
                 tree.node_bytes() + voxel_count * sizeof(PackedRgb) * (emits ? 2 : 1));
    if (stats != nullptr) *stats = measured;
    return tree;
}

}  // namespace probebake
