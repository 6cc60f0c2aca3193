// VoxelTree::build: sort by Morton code, then build in that order.
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>
#include <tuple>

#include "voxels/tree_builder.h"

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
    std::vector<Voxel>& voxels = cloud.voxels;
    TreeBuilder builder(cloud.depth);
    BuildStats measured;
    auto start = Clock::now();
    const uint64_t input_bytes = voxels.capacity() * sizeof(Voxel);

    const auto before = [](const Voxel& a, const Voxel& b) {
        return std::tie(a.key, a.albedo, a.emission) < std::tie(b.key, b.albedo, b.emission);
    };
    tbb::parallel_sort(voxels.begin(), voxels.end(), before);
    measured.duplicates = drop_duplicates(voxels);
    measured.sort_seconds = seconds_since(start);

    start = Clock::now();
    builder.reserve(voxels.size());
    builder.append(voxels);
    measured.peak_bytes = input_bytes + builder.memory_bytes();
    std::vector<Voxel>().swap(voxels);
    measured.tree_seconds = seconds_since(start);

    start = Clock::now();
    VoxelTree tree = builder.finish(cloud.emission_scale);
    measured.color_seconds = seconds_since(start);
    if (stats != nullptr) *stats = measured;
    return tree;
}

}  // namespace probebake
