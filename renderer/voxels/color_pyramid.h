// Colours of every octree node, kept out of the traversal's nodes.
//
// Three arrays in the order of the VoxelTree: voxels (level 0), octants (odd levels), nodes (even
// levels from 2). Each inner colour is the mean over its non-empty children (Müller 2020, 3.1),
// averaged in float from the leaves up and rounded once. Albedo and emission are kept apart; a
// world without emission has no emission arrays.
#pragma once

#include <cstdint>
#include <vector>

#include "math/shared_exponent.h"

namespace probebake {

/// Where in a ColorLevels the value of an octree node stands.
struct ColorIndex {
    enum class Array : uint8_t { kVoxels, kOctants, kNodes };
    Array array = Array::kVoxels;
    uint32_t index = 0;

    bool operator==(const ColorIndex&) const = default;
};

/// One quantity per octree node. `scale` (a power of two) × unpacked value = the quantity.
struct ColorLevels {
    std::vector<PackedRgb> voxels;
    std::vector<PackedRgb> octants;
    std::vector<PackedRgb> nodes;
    float scale = 1.0f;

    bool empty() const { return voxels.empty(); }
    Rgb operator[](ColorIndex at) const {
        const std::vector<PackedRgb>& array = at.array == ColorIndex::Array::kVoxels    ? voxels
                                              : at.array == ColorIndex::Array::kOctants ? octants
                                                                                        : nodes;
        return unpack_rgb(array[at.index]) * scale;
    }
    uint64_t memory_bytes() const {
        return (voxels.size() + octants.size() + nodes.size()) * sizeof(PackedRgb);
    }
    bool operator==(const ColorLevels&) const = default;
};

struct ColorPyramid {
    ColorLevels albedo;    // reflectance, 1
    ColorLevels emission;  // radiance, W·m⁻²·sr⁻¹; empty where nothing emits

    uint64_t memory_bytes() const { return albedo.memory_bytes() + emission.memory_bytes(); }
    bool operator==(const ColorPyramid&) const = default;
};

class VoxelTree;

/// Fills octants and nodes from `voxels` (packed, in tree order). Parallel on the calling arena.
ColorLevels average_up(const VoxelTree& tree, std::vector<PackedRgb> voxels, float scale);

}  // namespace probebake
