// Buildings with rooms, doors and windows, all with their walls along the axes.
#pragma once

#include "scene/generators/canvas.h"

namespace probebake::worldgen {

enum class Side { kWest, kEast, kNorth, kSouth };

struct House {
    Vec2 corner_m{0.0};  // lowest x and z
    Vec2 extent_m{8.0};
    double floor_m = 0.0;
    int storeys = 1;
    Side door = Side::kSouth;
    RandomStream random{0};
    double snow = 0.0;  // share of the roof that snow covers
};

/// Floor height at which no part of the footprint lies below the ground.
double floor_above_ground(const Canvas& canvas, const Vec2& corner_m, const Vec2& extent_m);

/// Blocks of stone, some lighter than others.
Paint masonry(const Canvas& canvas, const IVec3& voxel, const Rgb& stone);
/// One bright voxel.
void draw_lantern(Canvas& canvas, const Vec3& at_m);

/// Plastered cubes stacked on each other: flat roofs, parapets, beams showing, now and then a dome
/// or an awning, a lantern beside the door.
void draw_adobe_house(Canvas& canvas, House house);
/// Log walls under a gable roof, with a chimney and lit windows.
void draw_cabin(Canvas& canvas, House house);
/// Cloth on four posts over a counter with goods.
void draw_stall(Canvas& canvas, const Vec2& center_m, RandomStream& random);
/// A stone ring under a little roof.
void draw_well(Canvas& canvas, const Vec2& center_m);
/// A square tower of masonry with battlements; a fire burns on top where `beacon`.
struct Tower {
    Vec2 center_m{0.0};
    double width_m = 5.0;
    double height_m = 12.0;
    Rgb stone{0.3f, 0.28f, 0.25f};
    bool beacon = false;
    double snow = 0.0;
};
void draw_tower(Canvas& canvas, const Tower& tower);

}  // namespace probebake::worldgen
