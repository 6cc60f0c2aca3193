// Whether a place is one for a probe, and where a better one is nearby.
//
// Two things are asked. The voxel tree: is the place in a voxel, how near is the nearest one, and
// in which share of 64 directions, spread evenly, is one met within a voxel's edge ("closed in": 1
// in a voxel, a half or less beside a wall, more in clefts). Voxels have no sides: a room and the
// inside of a hollow wall look alike to them. So, where it is wanted and the scene has them, the
// triangles, through an object octree: in which share of the same directions is the back of one met
// first (as other bakers have it). Triangles with two fronts and those with holes have no back.
//
// The ground of a heightmap is solid: below its surface everything is inside.
#pragma once

#include <memory>

#include "scene/probe_place.h"
#include "scene/scene.h"

namespace probebake {

/// Of the cell of a grid, per axis: a moved probe stays nearer to its own place than to the next
/// one's.
inline constexpr double kMostCellShare = 0.45;

class SurfaceSides;

class PlaceFinder {
  public:
    /// Keeps a reference to the scene. `ask_triangles`: makes an object octree of those the scene
    /// has, for as long as this lives.
    PlaceFinder(const Scene& scene, const PlaceRules& rules, bool ask_triangles);
    ~PlaceFinder();
    PlaceFinder(const PlaceFinder&) = delete;
    PlaceFinder& operator=(const PlaceFinder&) = delete;

    ProbePlace look_at(const Vec3& position_m) const;

    /// The place nearest to `position_m` of a lattice of 7³ within ± `most_offset_m` per axis that
    /// is valid and has at least half a voxel of air on every side (closed in by at most a
    /// quarter), or else the nearest that is valid; of those equally near the one with the lower z,
    /// y, x. The position itself, bit for bit, where it is valid or nothing is.
    Vec3 relocated(const Vec3& position_m, const Vec3& most_offset_m) const;

    uint64_t octree_bytes() const;  // 0 where there is none

  private:
    /// As look_at says, for less; how much it is closed in where that may matter.
    bool is_valid(const Vec3& position_m, double& closed_in) const;

    const Scene& scene_;
    PlaceRules rules_;
    std::unique_ptr<const SurfaceSides> sides_;  // null where not asked
};

}  // namespace probebake
