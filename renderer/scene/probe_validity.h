// Whether a place is one for a probe, and where a better one is nearby.
//
// Judged by the voxel tree alone. A place in a voxel is inside geometry. "Backface" is the share of
// 64 directions, spread evenly, in which a voxel is met within one voxel's edge: 1 inside geometry,
// a half or less beside a wall, more in clefts and corners that light hardly reaches. What is
// closed in by thin walls is air: a room and the inside of a hollow wall look alike.
#pragma once

#include "scene/scene.h"

namespace probebake {

inline constexpr double kDefaultMaxBackface = 0.25;
/// Of the cell of a grid, per axis: a moved probe stays nearer to its own place than to the next
/// one's.
inline constexpr double kMostCellShare = 0.45;

struct ProbePlace {
    bool inside_geometry = false;
    double backface = 0.0;           // 0 to 1
    double nearest_surface_m = 0.0;  // 0 inside; infinite in a world without voxels

    bool is_valid(double max_backface) const {
        return !inside_geometry && backface <= max_backface;
    }
};

ProbePlace look_at_place(const Scene& scene, const Vec3& position_m);

/// The place nearest to `position_m` that is valid, of a lattice of 17³ within ± `most_offset_m`
/// per axis; of those equally near the one with the lower z, y, x. The position itself, bit for
/// bit, where it is valid or nothing is.
Vec3 relocated(const Scene& scene, const Vec3& position_m, const Vec3& most_offset_m,
               double max_backface = kDefaultMaxBackface);

}  // namespace probebake
