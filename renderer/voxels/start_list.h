// Where the rays of a narrow beam from one point may start: the nodes of the octree that the beam
// can meet, found once for all of its rays, in an order that is front to back for every one of
// them.
//
// Children seen from a point have one order for all rays: from the octant of the point on, axis by
// axis to the far side. So the first start node in which a ray hits something holds its first hit,
// and a ray that is traced through its list has the hit, to the bit, that it has from the root
// (Müller 2020, 6.2, restarts a refined ray at its parent's node instead, and misses what lies in
// front of that node).
#pragma once

#include <span>

#include "voxels/trace.h"

namespace probebake {

/// Rays from `origin` inside the pyramid of four directions, given around it, none of them 90°
/// from its middle.
struct Beam {
    Vec3 origin{0.0};
    std::array<Vec3, 4> edges{};
    double width = 0.0;  // side of the beam per distance
    double cone = 0.0;   // the widest that a ray of it is traced with (LevelOfDetail::cone)
};

/// A node of the octree, with its ancestors as in Hit::path.
struct StartNode {
    Vec3 low{0.0};  // opposite corners
    Vec3 high{0.0};
    IVec3 corner{0};
    int level = 0;
    std::array<uint32_t, kMaxNodeLevels> path{};
};

struct StartList {
    std::vector<StartNode> nodes;
    uint32_t steps = 0;  // non-empty octree nodes that the beam entered below the root
};

StartList start_list(const VoxelTree& tree, const Beam& beam);
/// The same for a beam inside the one that `from` was made for.
StartList start_list(const VoxelTree& tree, const Beam& beam, const StartList& from);

/// trace_through for a ray of the list's beam, with lod.fixed_level 0 and lod.cone at most the
/// beam's. Steps are those from the start nodes on, these included.
HitBehind trace_through(const VoxelTree& tree, const StartList& from, const Ray& ray,
                        const LevelOfDetail& lod, const TraceRange& range = {});
/// trace to the leaf for a ray of the list's beam.
Hit trace(const VoxelTree& tree, const StartList& from, const Ray& ray,
          const TraceRange& range = {});

}  // namespace probebake
