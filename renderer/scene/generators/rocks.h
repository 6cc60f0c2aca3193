// Rocks: ellipsoids bent by noise, drawn as shells, sunk into the ground.
#pragma once

#include <functional>

#include "scene/generators/canvas.h"
#include "scene/generators/landscape.h"
#include "scene/generators/noise.h"

namespace probebake::worldgen {

struct Rock {
    Vec3 center_m{0.0};
    Vec3 radii_m{1.0};
    double roughness = 0.3;  // of the surface, relative to the radius
    bool snowy = false;      // snow lies on what faces up
    uint64_t key = 0;
};

using RockColor = std::function<Rgb(const GroundPoint& point)>;

void draw_rock(Canvas& canvas, const Rock& rock, const RockColor& color);
/// A group of rocks around a spot, the largest of `radius_m`.
void draw_boulders(Canvas& canvas, Spot& spot, double radius_m, bool snowy, const RockColor& color);

}  // namespace probebake::worldgen
