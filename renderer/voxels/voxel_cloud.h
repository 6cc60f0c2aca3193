// Voxels as importers and generators hand them over: an unordered list, 16 bytes each.
//
// Positions are integers in [0, 65535] per axis, +Y up, edge 1. Colours are linear Rec.709. Two
// voxels may share a position: the one with the higher `order` wins (a later instance of a .vox
// file), ties go to the larger colour bits, so that the result never depends on the list's order.
#pragma once

#include <cstdint>
#include <vector>

#include "math/morton.h"
#include "math/shared_exponent.h"
#include "math/vec.h"

namespace probebake {

struct Voxel {
    uint64_t key = 0;  // Morton code << 16 | order
    PackedRgb albedo = 0;
    PackedRgb emission = 0;  // radiance / VoxelCloud::emission_scale

    uint64_t morton() const { return key >> 16; }
};
static_assert(sizeof(Voxel) == 16);

inline Voxel make_voxel(const IVec3& position, PackedRgb albedo, PackedRgb emission = 0,
                        uint16_t order = 0) {
    const uint64_t code =
        morton_encode(static_cast<uint32_t>(position.x), static_cast<uint32_t>(position.y),
                      static_cast<uint32_t>(position.z));
    return {code << 16 | order, albedo, emission};
}

struct VoxelCloud {
    std::vector<Voxel> voxels;
    /// Radiance (W·m⁻²·sr⁻¹) of a packed emission of 1; a power of two.
    float emission_scale = 1.0f;
    /// Side of the world as a power of two (log2), at least 2 and large enough for every voxel.
    int depth = 2;
};

/// Smallest depth (log2 of the side, 2..16) whose world holds `extent` voxels per axis.
/// Throws std::invalid_argument when an axis exceeds 65,536.
int depth_for_extent(const IVec3& extent);

}  // namespace probebake
