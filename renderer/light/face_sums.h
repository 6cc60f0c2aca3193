// FaceSums: the exposed faces below an octree node, added up, and what FaceColors keeps of them.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "light/air_regions.h"
#include "light/face_colors.h"

namespace probebake {

/// Light is told apart between regions of air whose brightest faces differ by more than this.
inline constexpr float kDividedRatio = 1.0f / 16.0f;

/// The faces below a node that front one region of air (air_regions.h).
struct RegionLight {
    int region = 0;
    uint8_t faces = 0;       // bit f: some of direction f
    float brightest = 0.0f;  // luminance
};

struct FaceSums {
    /// The faces of one direction.
    struct Group {
        Vec3 sum{0.0};                                           // of their radiance
        uint64_t count = 0;                                      // faces
        uint64_t lit = 0;                                        // of them: not black
        float darkest = std::numeric_limits<float>::infinity();  // least luminance
        float brightest = 0.0f;
        int low = std::numeric_limits<int>::max();  // extent along the normal's axis, voxels
        int high = std::numeric_limits<int>::min();

        void add(const Group& other) {
            sum += other.sum;
            count += other.count;
            lit += other.lit;
            darkest = std::min(darkest, other.darkest);
            brightest = std::max(brightest, other.brightest);
            low = std::min(low, other.low);
            high = std::max(high, other.high);
        }
    };
    std::array<Group, kFaceCount> groups;
    /// Within a block of several regions; empty elsewhere.
    std::vector<RegionLight> regions;
    /// Above blocks: the brightest face of the region of which that is darkest.
    float dimmest = std::numeric_limits<float>::infinity();

    void add(const FaceSums& other);
    /// To be called for the sums of a block, whose regions nothing outside knows.
    void leave_block();
};

/// The face directions, a bit each, whose mean may mislead a ray that meets the node from there: it
/// may come from air whose faces in the node are much darker. `air`: of the node's block; null for
/// nodes above blocks, where any of the node's regions may be where the ray comes from.
uint8_t divided_faces(const FaceSums& sums, const IVec3& corner, int edge, const AirRegions* air);

/// The exposed faces of one voxel; region: of the air before each, where the block has several.
FaceSums voxel_faces(const IVec3& position, uint8_t exposed,
                     const std::array<Rgb, kFaceCount>& radiance,
                     const std::array<int, kFaceCount>* region = nullptr);

/// Sizes everything for `colors.voxels.exposed`, which holds one byte per voxel: bytes of octants
/// and nodes, indices, room for values. Throws std::length_error beyond 2^32 − 1 values in one
/// array.
void lay_out(const VoxelTree& tree, FaceColors& colors);

/// Writes the values of a node, an octant or a voxel.
void write_means(FaceLevel& level, size_t node, const FaceSums& sums, const IVec3& corner, int edge,
                 float scale);

/// Adds up a 64-ary node of node level k at `corner` from child_sums(child index, child corner),
/// and writes it and its octants. `air`: as in divided_faces.
template <class ChildSums>
FaceSums add_up(const VoxelTree& tree, int k, uint32_t index, const IVec3& corner,
                const AirRegions* air, ChildSums& child_sums, FaceColors& out) {
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
        out.octants.divided[octant] = divided_faces(sums, octant_corner, edge / 2, air);
        write_means(out.octants, octant++, sums, octant_corner, edge / 2, out.scale);
        total.add(sums);
    }
    out.nodes.divided[index] = divided_faces(total, corner, edge, air);
    write_means(out.nodes, index, total, corner, edge, out.scale);
    return total;
}

}  // namespace probebake
