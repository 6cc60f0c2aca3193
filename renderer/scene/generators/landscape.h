// A landscape as data: a ground, its colours, what is scattered over it and what is built on it.
//
// voxelize() turns it into voxels at any resolution: the world always measures 512 m × 512 m
// (Müller 2020, chapter 4), so at 2048 voxels one is 25 cm. Tiles of columns run in parallel; a
// scattered object is drawn by the tile that holds its foot.
#pragma once

#include <functional>
#include <vector>

#include "scene/generators/canvas.h"
#include "scene/generators/erosion.h"
#include "scene/generators/ground.h"

namespace probebake::worldgen {

/// A voxel of the ground's shell.
struct GroundPoint {
    Vec3 at_m;
    double slope;     // rise over run
    double relief_m;  // > 0 on crests, < 0 in hollows
    double depth_m;   // below the top of its column: > 0 on the faces of cliffs
    double hash;      // uniform in [0, 1), per voxel
    Vec2 plan() const { return {at_m.x, at_m.z}; }
};

/// A place where something may stand.
struct Spot {
    Vec3 foot_m;  // on the ground
    double slope;
    RandomStream random;
    Vec2 plan() const { return {foot_m.x, foot_m.z}; }
};

/// At most one object in every cell of a jittered grid.
struct Scatter {
    double spacing_m;
    double detail_m;  // size of what must be resolved for the object to be drawn at all
    /// Decides from the spot whether anything grows there, and draws it.
    std::function<void(Spot& spot, Canvas& canvas)> draw;
};

struct Landscape {
    std::function<double(const Vec2& at_m)> height_m;
    std::function<Rgb(const GroundPoint& point)> color;
    std::vector<Scatter> scatters;
    std::vector<std::function<void(Canvas& canvas)>> structures;
};

/// Parallel on the calling arena; the same voxels in the same order for any number of threads.
VoxelCloud voxelize(const Landscape& landscape, int size, uint64_t seed);

Landscape make_desert(uint64_t seed);
Landscape make_forest(uint64_t seed);
Landscape make_mountain(uint64_t seed);
Landscape make_biomes(uint64_t seed);

}  // namespace probebake::worldgen
