// Scalar reference traversal of a VoxelTree, and what a hit says about the octree.
//
// The tree's own space: voxels of edge 1 in [0, 2^depth)³, t in voxels along a unit direction.
//
// A node is entered where its interval of t has positive length; every plane's parameter is the
// same double, (plane − origin) · (1 / direction), at every level, so that the intervals of the
// children tile their parent's exactly and ties go to the side the ray heads for. Children are
// chosen by these parameters alone (Gargantini and Atkinson 1993), never by a position, and
// nothing is advanced by an epsilon.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "math/cube_face.h"
#include "math/ray.h"
#include "voxels/voxel_tree.h"

namespace probebake {

/// Where a ray may stop above the voxels: at the first node whose level is at most `fixed_level`,
/// or whose edge is at most cone · t, t being where the ray enters the node.
struct LevelOfDetail {
    int fixed_level = 0;
    double cone = 0.0;  // node edge per distance, both in voxels
};

/// Hits before t_min are passed through (an opaque node that begins before t_min does not stop the
/// ray: its children may); hits after t_max are misses.
struct TraceRange {
    double t_min = 0.0;
    double t_max = std::numeric_limits<double>::infinity();
};

struct Hit {
    double t = std::numeric_limits<double>::infinity();  // voxels
    int level = -1;  // octree level of the node hit, 0 for a voxel; −1 for a miss
    CubeFace entry_face = CubeFace::kPosX;  // outward normal of the face that was met
    uint32_t steps = 0;      // non-empty octree nodes entered below the root, whatever came of it
    uint32_t box_tests = 0;  // start nodes tested (start_list.h)
    IVec3 corner{0};         // lowest voxel of the node hit
    Vec3 point{0.0};         // where the ray meets the node, voxels
    /// Index of the ancestor (or the node itself) at each node level; valid from (level − 1) / 2
    /// up.
    std::array<uint32_t, kMaxNodeLevels> path{};

    explicit operator bool() const { return level >= 0; }
};

/// First node along the ray at which it may stop. A ray with a component that is not finite, or
/// without direction, misses in 0 steps. Requires a unit direction where lod.cone > 0.
Hit trace(const VoxelTree& tree, const Ray& ray, const LevelOfDetail& lod = {},
          const TraceRange& range = {});

/// Asked about every node above the voxels at which the level of detail would let the ray stop;
/// where it says no, the ray goes on into the node's children.
class StopRule {
  public:
    virtual ~StopRule() = default;
    virtual bool stops(const Hit& node) = 0;
};
Hit trace(const VoxelTree& tree, const Ray& ray, const LevelOfDetail& lod, const TraceRange& range,
          StopRule& rule);

/// One walk to the voxel: `leaf` is the hit of trace(tree, ray, {}, range), `node` what
/// trace(tree, ray, lod, range) would have stopped at. Where the node is no ancestor of the leaf,
/// the ray went through it and past what it holds. Both have the steps of the whole walk.
struct HitBehind {
    Hit leaf;
    Hit node;
};
HitBehind trace_through(const VoxelTree& tree, const Ray& ray, const LevelOfDetail& lod,
                        const TraceRange& range = {});

/// Where the colour stands of the hit's ancestor at octree level `level` (hit.level ≤ level ≤
/// depth; hit.level is the node hit itself).
ColorIndex color_index(const VoxelTree& tree, const Hit& hit, int level);

/// Where the colours of a node's children stand: `count` of them in a row.
struct ColorRange {
    ColorIndex first;
    uint32_t count = 0;
};
/// Of the node hit, which is no voxel.
ColorRange child_colors(const VoxelTree& tree, const Hit& hit);

/// Child masks of the node hit and of its children, which is what the error of stopping there
/// depends on (Müller 2020, 5.1.4). A voxel counts as a full node: mask 255.
struct ChildMasks {
    uint8_t own = 255;
    uint8_t child_count = 0;  // children below the node; 0 for a voxel
    std::array<uint8_t, 8> children{};
};
ChildMasks child_masks(const VoxelTree& tree, const Hit& hit);

}  // namespace probebake
