// MagicaVoxel .vox file -> the voxels of its world.
//
// The file is +Z up, ours +Y up: points turn as (x, y, z) -> (x, z, −y), a rotation, so that the
// voxel cell [x, x+1) × [y, y+1) × [z, z+1) becomes the one with index (x, z, −y−1). A model turns
// about its pivot, the corner floor(size / 2) of its cells, and the pivot lands on the instance's
// translation (ogt_vox.h of opengametools, "Explanation of model pivots"). A transform maps points;
// a mirrored axis moves the cell p to −p − 1.
//
// Files without scene graph (before MagicaVoxel 0.99) have one model at the origin; if they have
// more, these are frames of an animation and the first is taken, as of any animation. Hidden nodes,
// and what is in hidden layers, are left out with all below them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "voxels/voxel_cloud.h"

namespace probebake {

/// What a file may ask for; more is an IoError, before any of it is allocated.
struct VoxLimits {
    /// Voxels of all visible instances, 16 bytes each (8 GiB); at most 2^32 − 1.
    uint64_t max_voxels = uint64_t{1} << 29;
    /// Visible instances; at most 65,536, which is what Voxel's 16 bits of order can tell apart.
    uint64_t max_instances = 65'536;
    /// Nodes met on the way through the scene graph, a shared node once per way to it: a small
    /// file can hold exponentially many ways. One instance meets four in MagicaVoxel's own files.
    uint64_t max_node_visits = uint64_t{1} << 22;
    /// Nodes above one another in the scene graph.
    int max_depth = 128;
};

struct VoxImport {
    /// Later instances in the order of the scene graph win over earlier ones (Voxel's order).
    VoxelCloud cloud;
    /// Where the cloud's (0, 0, 0) lies in the file's own space turned to +Y up, in voxels.
    IVec3 lowest{0};

    uint64_t models = 0;
    uint64_t instances = 0;          // visible ones
    uint64_t rotated_instances = 0;  // of these, turned or mirrored
    uint64_t hidden_instances = 0;   // left out
    uint64_t emissive_voxels = 0;    // of the cloud, before any loses its position to another
    std::vector<std::string> warnings;
};

/// Throws IoError, with chunk and offset, for a file that is damaged, lies about its sizes or asks
/// for more than the limits. Parallel over the instances on the calling arena.
VoxImport import_vox(std::span<const std::byte> bytes, const std::string& file_name,
                     const VoxLimits& limits = {});

}  // namespace probebake
