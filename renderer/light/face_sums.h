// FaceSums: the exposed faces below an octree node, added up, and what FaceColors keeps of them.
#pragma once

#include <algorithm>
#include <array>
#include <limits>

#include "light/face_colors.h"

namespace probebake {

struct FaceSums {
    /// The faces of one direction.
    struct Group {
        Vec3 sum{0.0};                                           // of their radiance
        uint64_t count = 0;                                      // faces
        uint64_t lit = 0;                                        // of them: not black
        float darkest = std::numeric_limits<float>::infinity();  // least luminance
        int low = std::numeric_limits<int>::max();  // extent along the normal's axis, voxels
        int high = std::numeric_limits<int>::min();

        void add(const Group& other) {
            sum += other.sum;
            count += other.count;
            lit += other.lit;
            darkest = std::min(darkest, other.darkest);
            low = std::min(low, other.low);
            high = std::max(high, other.high);
        }
    };
    std::array<Group, kFaceCount> groups;

    void add(const FaceSums& other) {
        for (size_t f = 0; f < kFaceCount; ++f) groups[f].add(other.groups[f]);
    }
};

/// The exposed faces of one voxel.
FaceSums voxel_faces(const IVec3& position, uint8_t exposed,
                     const std::array<Rgb, kFaceCount>& radiance);

/// Sizes everything for `colors.voxels.exposed`, which holds one byte per voxel: bytes of octants
/// and nodes, indices, room for values. Throws std::length_error beyond 2^32 − 1 values in one
/// array.
void lay_out(const VoxelTree& tree, FaceColors& colors);

/// Writes the values of a node, an octant or a voxel.
void write_means(FaceLevel& level, size_t node, const FaceSums& sums, const IVec3& corner, int edge,
                 float scale);

/// Adds up a 64-ary node of node level k at `corner` from child_sums(child index, child corner),
/// and writes it and its octants.
template <class ChildSums>
FaceSums add_up(const VoxelTree& tree, int k, uint32_t index, const IVec3& corner,
                ChildSums& child_sums, FaceColors& out) {
    const VoxelNode& node = tree.nodes()[index];
    const int edge = 4 << (2 * k);
    uint32_t child = node.first_child;
    uint32_t octant = node.octant_base;
    FaceSums total;
    for (int b = 0; b < 8; ++b) {
        const auto mask = static_cast<uint32_t>((node.mask >> (8 * b)) & 0xFFu);
        if (mask == 0) continue;
        const IVec3 octant_corner = corner + IVec3(b & 1, (b >> 1) & 1, (b >> 2) & 1) * (edge / 2);
        FaceSums sums;
        for (int c = 0; c < 8; ++c) {
            if (((mask >> c) & 1u) == 0) continue;
            sums.add(child_sums(
                child++, octant_corner + IVec3(c & 1, (c >> 1) & 1, (c >> 2) & 1) * (edge / 4)));
        }
        write_means(out.octants, octant++, sums, octant_corner, edge / 2, out.scale);
        total.add(sums);
    }
    write_means(out.nodes, index, total, corner, edge, out.scale);
    return total;
}

}  // namespace probebake
