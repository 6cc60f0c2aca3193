// One shadow ray: is a light seen from a point on a voxel's face?
//
// The ray starts on the face itself. Plane parameters make this exact: a face's plane is an
// integer, so that the ray leaves its own voxel at t = 0 and TraceRange.t_min = 0 passes it; no
// offset, and nothing in front of the face is missed.
//
// Level of detail (Müller 2020, 3.2.2): a node may block the ray where its edge is at most
// cone · t. What a node blocks that its voxels would let through darkens; so it may have to be
// shown to be solid first:
//
//   kDistance  never: a net becomes a wall where the level changes
//   kNode      the thesis: E_N(r) ≤ threshold (node_error.h); holes more than one level below the
//              children go unnoticed
//   kSubtree   e(r, M) ≤ threshold for the node and every node M below it. The walk over them ends
//              at the first that is not solid; nodes looked at are counted
#pragma once

#include <limits>

#include "error/node_error.h"
#include "voxels/trace.h"

namespace probebake {

enum class ShadowLod { kDistance, kNode, kSubtree };

struct ShadowSettings {
    ShadowLod lod = ShadowLod::kSubtree;
    double cone = 0.0;  // node edge per distance from the point; 0: voxels everywhere
    double threshold = kThesisThreshold;
    double decay = kThesisDecay;  // of kNode

    bool operator==(const ShadowSettings&) const = default;
};

struct ShadowResult {
    bool visible = false;
    Hit blocker;                // where not visible; its steps in any case
    uint32_t errors_asked = 0;  // nodes whose e was looked up
};

/// Whether anything blocks the unit-direction ray before `distance` (voxels; infinite for what is
/// far away). A node that holds the far end never blocks as a whole: its voxels may.
ShadowResult cast_shadow_ray(const VoxelTree& tree, const Ray& ray, double distance,
                             const ShadowSettings& settings = {});

/// Irradiance, W·m⁻², at a distance from a small light of radiant intensity I, W·sr⁻¹:
/// I · cos / distance². Distance in metres.
inline Rgb point_irradiance(const Rgb& intensity, double distance_m, double cosine) {
    if (!(cosine > 0.0) || !(distance_m > 0.0)) return Rgb(0.0f);
    return intensity * static_cast<float>(cosine / (distance_m * distance_m));
}

}  // namespace probebake
