#include "scene/generators/town.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/generators/palette.h"
#include "scene/generators/random.h"
#include "scene/generators/stands.h"
#include "scene/generators/structures.h"

namespace probebake::worldgen {
namespace {

constexpr double kLot_m = 10.4;
constexpr double kStreet_m = 3.4;  // half the width of the main street
constexpr double kSquare_m = 15.0;
const Rgb kTownStone{0.50f, 0.37f, 0.24f};

void draw_lot(Canvas& canvas, const Town& town, const Vec2& corner, RandomStream& random) {
    const Vec2 middle = corner + 0.5 * kLot_m;
    const Vec2 from_center = glm::abs(middle - town.center_m);
    if (glm::length(from_center) < kSquare_m + 4.0 || from_center.y < kStreet_m + 1.0) return;
    if (random.uniform() < 0.1) {
        // A garden instead of a house.
        Spot spot{{middle.x, canvas.ground().height_m(middle), middle.y}, 0.0, random};
        draw_palm(canvas,
                  plant_at(spot, palette::kPalm, palette::kBark, between(random, 5.0, 9.0)));
        return;
    }
    House house;
    house.extent_m = Vec2{between(random, 7.0, kLot_m - 0.8), between(random, 7.0, kLot_m - 0.8)};
    const Vec2 push = Vec2{random.uniform(), random.uniform()};
    house.corner_m = corner + (Vec2(kLot_m - 0.4) - house.extent_m) * push;
    house.storeys = 1 + static_cast<int>(random.below(glm::length(from_center) < 55.0 ? 4 : 3));
    house.door = middle.y < town.center_m.y ? Side::kSouth : Side::kNorth;
    if (random.uniform() < 0.35) house.door = random.uniform() < 0.5 ? Side::kWest : Side::kEast;
    house.random = RandomStream(random.next());
    house.floor_m = floor_above_ground(canvas, house.corner_m, house.extent_m);
    draw_adobe_house(canvas, house);
}

void draw_square(Canvas& canvas, const Town& town, RandomStream& random) {
    // Stalls in a ring, a well in the middle, a minaret at the corner.
    Vec3 azimuth = random_azimuth(random);
    for (int i = 0; i < 9; ++i) {
        azimuth =
            Vec3(0.766 * azimuth.x - 0.643 * azimuth.z, 0.0, 0.643 * azimuth.x + 0.766 * azimuth.z);
        const Vec2 at = town.center_m + 9.5 * Vec2(azimuth.x, azimuth.z);
        if (std::abs(at.y - town.center_m.y) < kStreet_m) continue;
        draw_stall(canvas, at, random);
    }
    draw_well(canvas, town.center_m);
    Tower minaret;
    minaret.center_m = town.center_m + Vec2(kSquare_m + 3.0, -kSquare_m + 1.0);
    minaret.width_m = 5.0;
    minaret.height_m = 24.0;
    minaret.stone = {0.62f, 0.53f, 0.40f};
    minaret.beacon = true;
    draw_tower(canvas, minaret);
}

}  // namespace

double Town::distance_m(const Vec2& at_m) const {
    const Vec2 outside = glm::abs(at_m - center_m) - half_m;
    return std::max(outside.x, outside.y);
}

bool Town::in_street(const Vec2& at_m) const {
    const Vec2 from = glm::abs(at_m - center_m);
    return distance_m(at_m) < 3.0 && (from.y < kStreet_m || glm::length(from) < kSquare_m);
}

void draw_town(Canvas& canvas, const Town& town, uint64_t key) {
    RandomStream random(key);
    const Vec2 lots = glm::floor((2.0 * town.half_m - 6.0) / kLot_m);
    const Vec2 lo = town.center_m - 0.5 * kLot_m * lots;
    for (double z = 0.0; z < lots.y; ++z) {
        const double shift = between(random, -0.3, 0.3);  // no street runs straight through
        for (double x = 0.0; x < lots.x; ++x) {
            draw_lot(canvas, town, lo + Vec2(x + shift, z) * kLot_m, random);
        }
    }
    draw_square(canvas, town, random);
    const Vec2 h = town.half_m;
    const std::vector<Vec2> corners = {town.center_m + Vec2(-h.x, -h.y),
                                       town.center_m + Vec2(h.x, -h.y), town.center_m + h,
                                       town.center_m + Vec2(-h.x, h.y)};
    draw_town_wall(canvas, corners, 5.2, 5.0, kTownStone);
    for (size_t i = 0; i < corners.size(); ++i) {
        Tower tower;
        tower.center_m = corners[i];
        tower.width_m = 6.0;
        tower.height_m = 9.5;
        tower.stone = kTownStone;
        draw_tower(canvas, tower);
        // Two smaller ones keep each gate.
        const Vec2 along = corners[(i + 1) % corners.size()] - corners[i];
        for (const double side : {-1.0, 1.0}) {
            tower.center_m = corners[i] + 0.5 * along + along / glm::length(along) * (side * 4.6);
            tower.width_m = 3.6;
            tower.height_m = 7.5;
            draw_tower(canvas, tower);
        }
    }
    for (double x = -h.x + 8.0; x < h.x; x += 14.0) {
        draw_lamp(canvas, town.center_m + Vec2(x, kStreet_m - 0.6), 3.2);
    }
}

double Hamlet::distance_m(const Vec2& at_m) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const House& cabin : cabins) {
        const Vec2 half = 0.5 * cabin.extent_m;
        const Vec2 outside = glm::abs(at_m - cabin.corner_m - half) - half;
        nearest = std::min(nearest, std::max(outside.x, outside.y));
    }
    return nearest;
}

double Hamlet::from_center_m(const Vec2& at_m) const { return glm::length(at_m - center_m); }

Hamlet plan_hamlet(const Vec2& center_m, double radius_m, double snow, uint64_t key) {
    constexpr int kCabins = 6;
    Hamlet hamlet{center_m, radius_m, snow, {}};
    RandomStream random(key);
    Vec3 azimuth = random_azimuth(random);
    for (int i = 0; i < kCabins; ++i) {
        // Turned by a sixth of a circle.
        azimuth = {0.5 * azimuth.x - 0.8660254 * azimuth.z, 0.0,
                   0.8660254 * azimuth.x + 0.5 * azimuth.z};
        House cabin;
        cabin.extent_m = Vec2{between(random, 6.0, 9.5), between(random, 5.5, 7.5)};
        if (random.uniform() < 0.5) std::swap(cabin.extent_m.x, cabin.extent_m.y);
        const double away = radius_m * between(random, 0.65, 1.0);
        cabin.corner_m = center_m + away * Vec2(azimuth.x, azimuth.z) - 0.5 * cabin.extent_m;
        if (std::abs(azimuth.x) > std::abs(azimuth.z)) {
            cabin.door = azimuth.x > 0.0 ? Side::kWest : Side::kEast;
        } else {
            cabin.door = azimuth.z > 0.0 ? Side::kNorth : Side::kSouth;
        }
        cabin.snow = snow;
        cabin.random = RandomStream(random.next());
        hamlet.cabins.push_back(cabin);
    }
    return hamlet;
}

void draw_hamlet(Canvas& canvas, const Hamlet& hamlet) {
    for (House cabin : hamlet.cabins) {
        cabin.floor_m = floor_above_ground(canvas, cabin.corner_m, cabin.extent_m);
        draw_cabin(canvas, cabin);
        // A fence around the garden, open on the side of the door.
        const Vec2 lo = cabin.corner_m - 3.5;
        const Vec2 hi = cabin.corner_m + cabin.extent_m + 3.5;
        const Vec2 nw = lo, ne(hi.x, lo.y), se = hi, sw(lo.x, hi.y);
        switch (cabin.door) {
            case Side::kNorth:
                draw_fence(canvas, {ne, se, sw, nw});
                break;
            case Side::kEast:
                draw_fence(canvas, {se, sw, nw, ne});
                break;
            case Side::kSouth:
                draw_fence(canvas, {sw, nw, ne, se});
                break;
            case Side::kWest:
                draw_fence(canvas, {nw, ne, se, sw});
                break;
        }
        const Vec2 to_green = hamlet.center_m - cabin.corner_m - 0.5 * cabin.extent_m;
        draw_lamp(canvas, hamlet.center_m - to_green * 0.6, 2.6);
    }
}

}  // namespace probebake::worldgen
