// What people build between houses: bridges, aqueducts, walls, fences, lamps, ruins, lines.
#pragma once

#include <vector>

#include "scene/generators/canvas.h"
#include "scene/generators/river.h"

namespace probebake::worldgen {

/// A plank deck with rails, rising towards the middle; the ends rest at the given heights.
void draw_bridge(Canvas& canvas, const Vec3& from_m, const Vec3& to_m, double width_m);
/// The same across a river, at a share of its length, from bank to bank.
void draw_river_bridge(Canvas& canvas, const River& river, double along, double width_m);

/// Two tiers of round arches carrying a channel at a level height, along +z.
struct Aqueduct {
    Vec2 from_m{0.0};
    double length_m = 100.0;
    double level_m = 60.0;
    double span_m = 9.0;
    Rgb stone{0.5f, 0.38f, 0.25f};
};
void draw_aqueduct(Canvas& canvas, const Aqueduct& aqueduct);

/// A wall of even height over the ground, with battlements, along a polygon's edges; gaps of
/// `gate_m` in the middle of each edge.
void draw_town_wall(Canvas& canvas, const std::vector<Vec2>& corners_m, double height_m,
                    double gate_m, const Rgb& stone);

/// Posts and two rails along a polyline.
void draw_fence(Canvas& canvas, const std::vector<Vec2>& through_m);
/// A post with a lantern.
void draw_lamp(Canvas& canvas, const Vec2& at_m, double height_m);
/// Columns in two rows, many broken, on a stepped base.
void draw_temple_ruin(Canvas& canvas, const Vec2& corner_m, RandomStream random);
/// A wooden lookout: four legs, braces, a roofed platform.
void draw_lookout(Canvas& canvas, const Vec2& at_m, double height_m, double snow);
/// Coloured flags on a line between two poles.
void draw_flags(Canvas& canvas, const Vec2& from_m, const Vec2& to_m, double height_m);
/// A line one voxel thick that sags by `sag_m` in the middle.
void draw_line(Canvas& canvas, const Vec3& from_m, const Vec3& to_m, double sag_m,
               const Paint& paint);

}  // namespace probebake::worldgen
