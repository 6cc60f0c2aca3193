// Settlements: a walled desert town on a flat, and a clearing with log cabins.
#pragma once

#include <vector>

#include "scene/generators/houses.h"
#include "scene/generators/landscape.h"

namespace probebake::worldgen {

/// A rectangle of streets and houses around a market square; the main street runs along x.
struct Town {
    Vec2 center_m{0.0};
    Vec2 half_m{70.0, 34.0};
    /// > 0 outside the town wall, metres.
    double distance_m(const Vec2& at_m) const;
    bool in_street(const Vec2& at_m) const;
};
void draw_town(Canvas& canvas, const Town& town, uint64_t key);

/// Cabins around a green, each with a fenced garden; doors face the middle.
struct Hamlet {
    Vec2 center_m{0.0};
    double radius_m = 26.0;
    double snow = 0.0;
    std::vector<House> cabins;
    /// Distance from the nearest cabin's walls.
    double distance_m(const Vec2& at_m) const;
    /// Distance from the middle of the green.
    double from_center_m(const Vec2& at_m) const;
};
Hamlet plan_hamlet(const Vec2& center_m, double radius_m, double snow, uint64_t key);
void draw_hamlet(Canvas& canvas, const Hamlet& hamlet);

}  // namespace probebake::worldgen
