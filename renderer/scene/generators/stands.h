// What grows together: recipes that choose species, size and hue from a spot's random numbers.
#pragma once

#include "scene/generators/landscape.h"
#include "scene/generators/plants.h"
#include "scene/generators/rocks.h"

namespace probebake::worldgen {

/// A plant at the spot, its leaf colour varied from plant to plant.
Plant plant_at(Spot& spot, const Rgb& leaf, const Rgb& bark, double height_m, double foliage = 1.0);

/// Shares of what stands in a forest; what is left over is broadleaf.
struct Stand {
    double conifers = 0.6;
    double birches = 0.1;
    double autumn = 0.1;  // of the broadleaf and birches, those that have turned
    double dead = 0.02;
    double snow = 0.0;     // on the upper leaves
    double stature = 1.0;  // relative to full height
    double foliage = 1.0;  // relative to a full crown
};
void plant_tree(Canvas& canvas, Spot& spot, const Stand& stand);
/// Bushes, ferns, stumps, logs.
void plant_undergrowth(Canvas& canvas, Spot& spot, double snow);
/// Blades of grass up to a height, now and then a flower.
void plant_meadow(Canvas& canvas, Spot& spot, double dryness, double height_m);
/// Thorn bushes, straw, cacti.
void plant_desert_shrub(Canvas& canvas, Spot& spot);

}  // namespace probebake::worldgen
