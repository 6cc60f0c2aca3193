// Everything green (or dry) that is no tree: bushes, shrubs, cacti, tufts, flowers, litter.
#pragma once

#include "scene/generators/trees.h"

namespace probebake::worldgen {

/// A rounded bush of leaves, or a sparse one where density is low.
void draw_bush(Canvas& canvas, Plant plant);
/// Bare twigs with few leaves.
void draw_dry_shrub(Canvas& canvas, Plant plant);
/// A column with raised arms.
void draw_cactus(Canvas& canvas, Plant plant);
/// A few blades, one to three voxels high; `height_m` of the tallest.
void draw_tuft(Canvas& canvas, Plant plant, double radius_m);
/// A lying trunk.
void draw_log(Canvas& canvas, Plant plant);
void draw_stump(Canvas& canvas, Plant plant);

}  // namespace probebake::worldgen
