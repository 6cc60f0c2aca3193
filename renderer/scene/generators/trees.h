// Trees: a skeleton of tapering limbs in metres, with leaves in small clouds along the twigs.
//
// Limbs and leaves come from the plant's own random stream, so a tree has the same build at every
// resolution.
#pragma once

#include "scene/generators/canvas.h"

namespace probebake::worldgen {

struct Plant {
    Vec3 foot_m{0.0};
    double height_m = 10.0;
    RandomStream random{0};
    Rgb leaf{0.05f, 0.1f, 0.03f};
    Rgb bark{0.1f, 0.07f, 0.05f};
    double snow = 0.0;     // share of the upper leaves that carry snow
    double density = 1.0;  // of the foliage, relative to what the species has
};

/// The plant's leaves, `tint` times as bright; density as in Foliage.
Foliage leaves_of(const Plant& plant, double density_per_m, double tint);

/// Whorls of drooping branches in a narrow cone.
void draw_spruce(Canvas& canvas, Plant plant);
/// A long bare trunk under flat, tufted clouds of needles.
void draw_pine(Canvas& canvas, Plant plant);
/// Forking limbs under a domed, lobed crown.
void draw_broadleaf(Canvas& canvas, Plant plant);
/// A slim white trunk, thin hanging foliage.
void draw_birch(Canvas& canvas, Plant plant);
/// Limbs without leaves.
void draw_dead_tree(Canvas& canvas, Plant plant);
/// A leaning trunk with a crown of arching fronds.
void draw_palm(Canvas& canvas, Plant plant);
/// A forked trunk under a flat umbrella.
void draw_acacia(Canvas& canvas, Plant plant);
/// A dark, closed column.
void draw_cypress(Canvas& canvas, Plant plant);

}  // namespace probebake::worldgen
