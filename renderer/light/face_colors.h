// FaceColors: lit radiance per exposed face of every octree node, W·m⁻²·sr⁻¹.
//
// A voxel's face is exposed where the voxel beside it is empty, a node's face direction where any
// voxel below it has such a face. A node keeps the mean over those of its faces that are not black
// and their share: value × share is the mean over all, each counting alike (the same voxel area),
// so that radiance times area adds up to the same at every level.
//
// Light does not leak: one value per direction keeps a sunlit one-voxel wall dark inside.
//
// A node is divided in a face direction where a ray may meet that side of it from two sides of a
// wall, in light that differs by more than 1 : 16: floor of a closed room and sunlit ground
// outside. The mean is right for neither; what is shown is finer (FaceColors::seen). Air that is
// not joined within a node's block of 16³ voxels counts as two sides; above the blocks a node is
// divided where anything in it fronts air so much darker than the direction's brightest face.
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

/// What else is known of the faces of one direction in a node above the voxels: where along their
/// normal's axis they lie, in steps of 1/128 of the node's edge from its lowest corner, rounded
/// outwards; how many are not black; how dark the darkest is.
struct FaceGroup {
    static constexpr int kSteps = 128;
    static constexpr int kAll = 255;

    uint8_t low = 0;
    uint8_t high = 0;
    uint8_t share = kAll;    // of faces that are not black, in 1/255; 0 only where there is none
    uint8_t darkest = kAll;  // luminance of the darkest face in 1/255 of the value's, rounded down

    bool operator==(const FaceGroup&) const = default;
};
static_assert(sizeof(FaceGroup) == 4);

/// The faces of one of the tree's arrays.
struct FaceLevel {
    std::vector<uint8_t> exposed;   // per node, padded to whole words of eight
    std::vector<uint32_t> first;    // per word
    std::vector<PackedRgb> values;  // per exposed face direction of a node
    std::vector<FaceGroup> groups;  // the same; empty for voxels
    std::vector<uint8_t> divided;   // per node, bit f: in face direction f; empty for voxels

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
               values.size() * sizeof(PackedRgb) + groups.size() * sizeof(FaceGroup) +
               divided.size();
    }
    bool operator==(const FaceLevel&) const = default;
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

    /// What a ray of this direction sees of a hit in the colours of its ancestor at octree level
    /// `level` (hit.level: the node hit itself): the mean over its faces of the direction met.
    ///
    /// A divided ancestor gives way to the next below it. A divided node that was hit is shown as
    /// the first undivided one that the ray meets from there on: that stands in the ray's own air.
    /// Where it meets none it leaves the world, and was in no room: it sees the node's mean.
    ///
    /// A node that does not expose the direction of the face that was met is a box that was met at
    /// a side without faces. Whatever the ray might have met below lies in front of hit.point, and
    /// across the direction it came from: a straight way from hit.point to any voxel of the node
    /// enters one through such a face. So the least of the darkest faces of the directions in front
    /// of hit.point is never brighter than something that is on this side of all walls; directions
    /// partly in front, partly behind count as black. A voxel's unexposed face is black.
    /// The steps of that ray are added to `steps`.
    Rgb seen(const VoxelTree& tree, const Vec3& direction, const Hit& hit, int level,
             uint32_t& steps) const;
    /// Whether the ancestor is divided in the direction of the face that was met.
    bool divided(const VoxelTree& tree, const Hit& hit, int level) const {
        if (level <= 0) return false;
        const ColorIndex at = color_index(tree, hit, level);
        const int face = probebake::index_of(hit.entry_face);
        return ((this->level(at.array).divided[at.index] >> face) & 1u) != 0;
    }

    uint64_t face_count() const { return voxels.values.size(); }
    uint64_t memory_bytes() const {
        return voxels.memory_bytes() + octants.memory_bytes() + nodes.memory_bytes();
    }
    bool operator==(const FaceColors&) const = default;

  private:
    Rgb value_of(const VoxelTree& tree, const Hit& hit, int level) const;
};

}  // namespace probebake
