// Probe positions for a first look at a scene: spread over it, in free air above the ground.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace probebake {

/// Up to `count` positions in metres, one in each cell of a grid over the scene's ground plan, two
/// to ten metres above what a ray from above meets first and clear of voxels around; fewer where
/// there is little room, none in an empty scene. Throws std::invalid_argument for a negative count.
std::vector<Vec3> suggest_probes(const Scene& scene, int count, uint64_t seed = 1);

}  // namespace probebake
