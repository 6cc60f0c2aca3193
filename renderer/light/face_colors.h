// FaceColors: lit radiance per exposed face of every octree node, W·m⁻²·sr⁻¹.
//
// A voxel's face is exposed where the voxel beside it is empty, a node's face direction where any
// voxel below it has such a face; a node's value is the mean over those faces, each counting alike
// (the same voxel area), so that radiance times area adds up to the same at every level. One value
// per direction keeps light from leaking through walls: a sunlit one-voxel wall is dark inside.
//
// A ray that stops at a node may enter it through a side that exposes nothing (flat ground is
// entered from the side all the time). It is shown the darkest of what lies in front of its entry
// point; see FaceColors::seen.
//
// Layout: like ColorLevels three arrays of nodes (voxels, octants, nodes of the tree). A node has
// one byte, bit f set where face direction f is exposed; eight of these bytes are one word, whose
// first value is indexed: value of (node, f) = first[node / 8] + number of set bits below f's.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "math/cube_face.h"
#include "voxels/trace.h"

namespace probebake {

/// Of the faces of one direction in a node above the voxels: where along their normal's axis they
/// lie, in steps of 1/32 of the node's edge from its lowest corner, rounded outwards; and how dark
/// the darkest is.
struct FaceGroup {
    static constexpr int kSteps = 32;
    static constexpr int kFull = 15;

    uint16_t low : 6 = 0;
    uint16_t high : 6 = 0;
    uint16_t darkest : 4 = kFull;  // its luminance in fifteenths of the mean's, rounded down
};
static_assert(sizeof(FaceGroup) == 2);

/// The faces of one of the tree's arrays.
struct FaceLevel {
    std::vector<uint8_t> exposed;   // per node, padded to whole words of eight
    std::vector<uint32_t> first;    // per word
    std::vector<PackedRgb> values;  // per exposed face direction of a node
    std::vector<FaceGroup> groups;  // the same; empty for voxels

    uint64_t word(size_t node) const {
        uint64_t bits = 0;
        std::memcpy(&bits, exposed.data() + (node & ~size_t{7}), sizeof(bits));
        return bits;
    }
    bool exposes(size_t node, int face) const { return ((exposed[node] >> face) & 1u) != 0; }
    /// Index of the value of a face direction that the node exposes.
    size_t index_of(size_t node, int face) const {
        const uint64_t below = (uint64_t{1} << (8 * (node & 7) + static_cast<size_t>(face))) - 1;
        return first[node / 8] + static_cast<size_t>(std::popcount(word(node) & below));
    }
    uint64_t memory_bytes() const {
        return exposed.size() + first.size() * sizeof(uint32_t) +
               values.size() * sizeof(PackedRgb) + groups.size() * sizeof(FaceGroup);
    }
    bool operator==(const FaceLevel& other) const;
};

struct FaceColors {
    FaceLevel voxels;
    FaceLevel octants;
    FaceLevel nodes;
    float scale = 1.0f;  // a power of two: scale × unpacked value = radiance

    const FaceLevel& level(ColorIndex::Array array) const {
        return array == ColorIndex::Array::kVoxels    ? voxels
               : array == ColorIndex::Array::kOctants ? octants
                                                      : nodes;
    }

    /// What a ray sees of the hit's ancestor at octree level `level` (the node hit itself at
    /// hit.level). Where the ancestor exposes the direction of the face that was met, its mean.
    ///
    /// Where it does not, the ray met the box of a node at a side without faces. Whatever it might
    /// have met below lies in front of hit.point, and across the direction it came from: a straight
    /// way from hit.point to any voxel of the node enters it through such a face. So the least of
    /// the darkest faces of the directions in front of hit.point is never brighter than something
    /// that is on this side of all walls; directions partly in front, partly behind count as black.
    /// A voxel's unexposed face is black.
    Rgb seen(const VoxelTree& tree, const Hit& hit, int level) const;

    uint64_t face_count() const { return voxels.values.size(); }
    uint64_t memory_bytes() const {
        return voxels.memory_bytes() + octants.memory_bytes() + nodes.memory_bytes();
    }
    bool operator==(const FaceColors&) const = default;
};

}  // namespace probebake
