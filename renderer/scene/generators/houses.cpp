#include "scene/generators/houses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "scene/generators/noise.h"
#include "scene/generators/palette.h"
#include "scene/generators/random.h"

namespace probebake::worldgen {
namespace {

constexpr double kStorey_m = 3.0;
constexpr double kFoundation_m = 2.5;
const Rgb kLampLight = Rgb(1.0f, 0.62f, 0.25f) * 900.0f;
const Rgb kWindowLight = Rgb(1.0f, 0.66f, 0.30f) * 18.0f;

struct Box {
    Vec3 lo;
    Vec3 hi;
    bool holds(const Vec3& p) const {
        return p.x >= lo.x && p.y >= lo.y && p.z >= lo.z && p.x < hi.x && p.y < hi.y && p.z < hi.z;
    }
};

/// Upright walls, one voxel thick, around a box, except where an opening is.
void draw_walls(Canvas& canvas, const Box& room, const std::vector<Box>& openings,
                const std::function<Paint(const IVec3&)>& paint) {
    const IVec3 lo = canvas.voxel_at(room.lo);
    const IVec3 hi = glm::max(canvas.voxel_at(room.hi), lo + IVec3(2, 1, 2));
    for (int y = lo.y; y < hi.y; ++y) {
        for (int z = lo.z; z < hi.z; ++z) {
            const bool end_wall = z == lo.z || z == hi.z - 1;
            for (int x = lo.x; x < hi.x; x += end_wall ? 1 : hi.x - 1 - lo.x) {
                const Vec3 at = canvas.center_m({x, y, z});
                const bool open = std::any_of(openings.begin(), openings.end(),
                                              [&](const Box& box) { return box.holds(at); });
                if (!open) canvas.put({x, y, z}, paint({x, y, z}));
            }
        }
    }
}

bool along_x(Side side) { return side == Side::kNorth || side == Side::kSouth; }

/// A box of `width` × `height` through one wall of the room, centred at `share` of its length.
Box opening_in(const Box& room, Side side, double share, const Vec2& size, double sill) {
    const Vec3 middle = room.lo + (room.hi - room.lo) * share;
    Box box{{0.0, room.lo.y + sill, 0.0}, {0.0, room.lo.y + sill + size.y, 0.0}};
    const double depth = 0.4;
    if (along_x(side)) {
        const double wall = side == Side::kNorth ? room.lo.z : room.hi.z;
        box.lo.x = middle.x - 0.5 * size.x;
        box.hi.x = middle.x + 0.5 * size.x;
        box.lo.z = wall - depth;
        box.hi.z = wall + depth;
    } else {
        const double wall = side == Side::kWest ? room.lo.x : room.hi.x;
        box.lo.z = middle.z - 0.5 * size.x;
        box.hi.z = middle.z + 0.5 * size.x;
        box.lo.x = wall - depth;
        box.hi.x = wall + depth;
    }
    return box;
}

Vec3 outward(Side side) {
    switch (side) {
        case Side::kWest:
            return {-1.0, 0.0, 0.0};
        case Side::kEast:
            return {1.0, 0.0, 0.0};
        case Side::kNorth:
            return {0.0, 0.0, -1.0};
        case Side::kSouth:
            break;
    }
    return {0.0, 0.0, 1.0};
}

constexpr std::array<Side, 4> kSides = {Side::kWest, Side::kEast, Side::kNorth, Side::kSouth};

std::vector<Box> windows_of(const Box& room, RandomStream& random, Side door, bool has_door) {
    std::vector<Box> openings;
    for (const Side side : kSides) {
        const double length = along_x(side) ? room.hi.x - room.lo.x : room.hi.z - room.lo.z;
        const int count = static_cast<int>(length / 3.0);
        for (int i = 0; i < count; ++i) {
            const double share = (i + 0.5) / count;
            const bool at_door = has_door && side == door && std::abs(share - 0.5) * length < 1.6;
            if (at_door || random.uniform() < 0.25) continue;
            openings.push_back(opening_in(room, side, share, {0.8, 1.1}, 1.1));
        }
    }
    if (has_door) openings.push_back(opening_in(room, door, 0.5, {1.3, 2.3}, -0.1));
    return openings;
}

void draw_dome(Canvas& canvas, const Vec3& base_m, double radius_m, const Paint& paint) {
    const IVec3 lo = canvas.voxel_at(base_m - Vec3(radius_m, 0.0, radius_m));
    const IVec3 hi = canvas.voxel_at(base_m + Vec3(radius_m));
    for (int z = lo.z; z <= hi.z; ++z) {
        for (int y = lo.y; y <= hi.y; ++y) {
            for (int x = lo.x; x <= hi.x; ++x) {
                const Vec3 d = canvas.center_m({x, y, z}) - base_m;
                const double r = std::sqrt(glm::dot(d, d));
                if (r <= radius_m && r > radius_m - 1.8 * canvas.voxel_m()) {
                    canvas.put({x, y, z}, paint);
                }
            }
        }
    }
}

Rgb plaster_color(RandomStream& random) {
    constexpr std::array<Rgb, 7> kTones = {Rgb(0.58f, 0.44f, 0.30f), Rgb(0.66f, 0.55f, 0.41f),
                                           Rgb(0.50f, 0.32f, 0.19f), Rgb(0.72f, 0.66f, 0.56f),
                                           Rgb(0.47f, 0.27f, 0.16f), Rgb(0.60f, 0.47f, 0.29f),
                                           Rgb(0.42f, 0.46f, 0.44f)};
    const Rgb tone = kTones[random.below(kTones.size())];
    return tone * static_cast<float>(between(random, 0.85, 1.12));
}

/// Striped cloth over [lo, hi) at one height.
void draw_cloth(Canvas& canvas, const Vec3& lo_m, const Vec3& hi_m, bool stripes_along_x,
                RandomStream& random) {
    constexpr std::array<Rgb, 5> kCloths = {Rgb(0.42f, 0.075f, 0.045f), Rgb(0.07f, 0.15f, 0.26f),
                                            Rgb(0.46f, 0.29f, 0.06f), Rgb(0.09f, 0.20f, 0.12f),
                                            Rgb(0.30f, 0.10f, 0.16f)};
    const Rgb cloth = kCloths[random.below(kCloths.size())];
    const IVec3 lo = canvas.voxel_at(lo_m);
    const IVec3 hi = glm::max(canvas.voxel_at(hi_m), lo + 1);
    const int stripe = std::max(1, static_cast<int>(std::lround(0.5 / canvas.voxel_m())));
    for (int z = lo.z; z < hi.z; ++z) {
        for (int x = lo.x; x < hi.x; ++x) {
            const int across = stripes_along_x ? z - lo.z : x - lo.x;
            const Rgb color = (across / stripe) % 2 == 0 ? Rgb(0.62f, 0.58f, 0.50f) : cloth;
            canvas.put({x, lo.y, z}, {color, 0.08});
        }
    }
}

/// Cloth on two poles in front of a wall.
void draw_awning(Canvas& canvas, const Box& room, Side side, RandomStream& random) {
    constexpr double kDepth_m = 2.2;
    constexpr double kHeight_m = 2.5;
    const Vec3 out = outward(side) * kDepth_m;
    // The strip of ground in front of that wall.
    Vec3 lo = room.lo;
    Vec3 hi = room.hi;
    const int axis = along_x(side) ? 2 : 0;
    (out[axis] > 0.0 ? lo : hi)[axis] = (out[axis] > 0.0 ? hi : lo)[axis];
    (out[axis] > 0.0 ? hi : lo)[axis] += out[axis];
    lo.y = hi.y = room.lo.y + kHeight_m;
    draw_cloth(canvas, lo, hi, !along_x(side), random);
    const Paint pole{palette::kTimberDark, 0.1};
    for (const Vec3& corner : {lo, hi}) {
        Vec3 top = corner;
        top[axis] = (out[axis] > 0.0 ? hi : lo)[axis] - 0.1 * out[axis];
        top[2 - axis] += corner == lo ? 0.2 : -0.2;
        canvas.limb(top - Vec3(0.0, kHeight_m + 1.0, 0.0), top, {0.06, 0.06}, pole);
    }
}

/// Beams of the ceiling, showing through two opposite walls.
void draw_beam_ends(Canvas& canvas, const Box& room) {
    if (!canvas.resolves(0.2)) return;
    const Paint timber{palette::kTimberDark, 0.15};
    for (double x = room.lo.x + 0.9; x < room.hi.x - 0.4; x += 1.1) {
        for (const double z : {room.lo.z - 0.2, room.hi.z + 0.2}) {
            canvas.put(canvas.voxel_at({x, room.hi.y - 0.4, z}), timber);
        }
    }
}

/// A roof whose ridge runs along the longer side and which overhangs by half a metre; the walls
/// below its ends are filled up. Returns the height of the ridge.
double draw_gable_roof(Canvas& canvas, const House& house, const Box& room, RandomStream& random,
                       const std::function<Paint(const IVec3&)>& wall) {
    constexpr double kPitch = 0.85;
    const Rgb tiles = mix(palette::kSlate, palette::kTimberDark, random.uniform());
    const int across = house.extent_m.x >= house.extent_m.y ? 2 : 0;
    const int along = 2 - across;
    const double middle = 0.5 * (room.lo[across] + room.hi[across]);
    const double half = 0.5 * (room.hi[across] - room.lo[across]);
    const IVec3 lo = canvas.voxel_at(room.lo - Vec3(0.5, 0.0, 0.5));
    const IVec3 hi = canvas.voxel_at(room.hi + Vec3(0.5, 0.0, 0.5));
    const IVec3 inner_lo = canvas.voxel_at(room.lo);
    const IVec3 inner_hi = canvas.voxel_at(room.hi) - 1;
    for (int z = lo.z; z <= hi.z; ++z) {
        for (int x = lo.x; x <= hi.x; ++x) {
            const IVec3 column(x, inner_hi.y, z);
            const double inward = half - std::abs(canvas.center_m(column)[across] - middle);
            const int y = canvas.voxel_at(Vec3(0.0, room.hi.y + kPitch * inward, 0.0)).y;
            const bool snowy = canvas.hash({x, y, z}) < house.snow;
            canvas.put({x, y, z}, {snowy ? palette::kSnow : tiles, snowy ? 0.03 : 0.2});
            canvas.put({x, y - 1, z}, {tiles, 0.2});
            const bool end = column[along] == inner_lo[along] || column[along] == inner_hi[along];
            for (int fill = inner_hi.y + 1; end && inward > 0.0 && fill < y - 1; ++fill) {
                canvas.put({x, fill, z}, wall({x, fill, z}));
            }
        }
    }
    return room.hi.y + kPitch * half;
}

}  // namespace

Paint masonry(const Canvas& canvas, const IVec3& v, const Rgb& stone) {
    // Courses of blocks, two voxels long, each second one shifted.
    const IVec3 block((v.x + (v.y & 1)) / 2, v.y, (v.z + (v.y & 1)) / 2);
    const double tone = 0.82 + 0.36 * canvas.hash(block);
    return {stone * static_cast<float>(tone), 0.06};
}

void draw_lantern(Canvas& canvas, const Vec3& at_m) {
    canvas.put(canvas.voxel_at(at_m), {Rgb(0.7f, 0.5f, 0.25f), 0.0, Layer::kLight, kLampLight});
}

double floor_above_ground(const Canvas& canvas, const Vec2& corner_m, const Vec2& extent_m) {
    double floor = 0.0;
    for (const Vec2 share : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1), Vec2(0.5, 0.5)}) {
        floor = std::max(floor, canvas.ground().height_m(corner_m + share * extent_m));
    }
    return floor + canvas.voxel_m();
}

void draw_adobe_house(Canvas& canvas, House house) {
    RandomStream& random = house.random;
    const Rgb tone = plaster_color(random);
    const Paint plaster{tone, 0.07};
    const Paint roof{tone * 0.86f, 0.12};
    const auto paint_wall = [&](const IVec3&) { return plaster; };
    Vec2 corner = house.corner_m;
    Vec2 extent = house.extent_m;
    for (int storey = 0; storey < house.storeys; ++storey) {
        const double floor = house.floor_m + storey * kStorey_m;
        const Box room{{corner.x, floor, corner.y},
                       {corner.x + extent.x, floor + kStorey_m, corner.y + extent.y}};
        Box walls = room;
        walls.hi.y += between(random, 0.5, 0.9);  // the parapet
        if (storey == 0) walls.lo.y -= kFoundation_m;
        draw_walls(canvas, walls, windows_of(room, random, house.door, storey == 0), paint_wall);
        const double slab = canvas.voxel_m();
        canvas.box({room.lo.x, room.hi.y - slab, room.lo.z}, {room.hi.x, room.hi.y, room.hi.z},
                   roof);
        draw_beam_ends(canvas, room);
        if (storey == 0) {
            if (random.uniform() < 0.3) draw_awning(canvas, room, house.door, random);
            if (random.uniform() < 0.5) {
                const Box door = opening_in(room, house.door, 0.5, {1.3, 2.3}, 0.0);
                const Vec3 beside = 0.5 * (door.lo + door.hi) + outward(house.door) * 0.2 +
                                    (along_x(house.door) ? Vec3(1.1, 0.9, 0) : Vec3(0, 0.9, 1.1));
                draw_lantern(canvas, beside);
            }
        }
        const bool last = storey + 1 == house.storeys;
        const double smaller = std::min(extent.x, extent.y);
        if (last && smaller > 4.5 && random.uniform() < 0.16) {
            draw_dome(canvas, {corner.x + 0.5 * extent.x, room.hi.y, corner.y + 0.5 * extent.y},
                      0.42 * smaller, {Rgb(0.70f, 0.64f, 0.54f), 0.06});
        }
        // The next storey stands back on some sides and leaves a terrace.
        const Vec2 shrink{between(random, 0.5, 1.0), between(random, 0.5, 1.0)};
        const Vec2 push{random.below(2), random.below(2)};
        corner += extent * (1.0 - shrink) * push;
        extent *= shrink;
    }
}

void draw_stall(Canvas& canvas, const Vec2& center_m, RandomStream& random) {
    const Vec2 half(1.8, 1.3);
    const double floor = floor_above_ground(canvas, center_m - half, 2.0 * half);
    const Vec3 lo(center_m.x - half.x, floor + 2.3, center_m.y - half.y);
    const Vec3 hi(center_m.x + half.x, floor + 2.3, center_m.y + half.y);
    draw_cloth(canvas, lo, hi, false, random);
    const Paint wood{palette::kTimberDark, 0.15};
    for (const double x : {lo.x + 0.1, hi.x - 0.1}) {
        for (const double z : {lo.z + 0.1, hi.z - 0.1}) {
            canvas.limb({x, floor - 1.0, z}, {x, lo.y, z}, {0.05, 0.05}, wood);
        }
    }
    canvas.box({lo.x + 0.5, floor, lo.z + 0.7}, {hi.x - 0.5, floor + 0.75, hi.z - 0.7}, wood);
    constexpr std::array<Rgb, 5> kGoods = {Rgb(0.45f, 0.20f, 0.04f), Rgb(0.30f, 0.06f, 0.03f),
                                           Rgb(0.16f, 0.24f, 0.05f), Rgb(0.50f, 0.38f, 0.10f),
                                           Rgb(0.42f, 0.36f, 0.30f)};
    for (double x = lo.x + 0.6; x < hi.x - 0.6; x += 0.5) {
        const Paint goods{kGoods[random.below(kGoods.size())], 0.25};
        canvas.box({x, floor + 0.75, lo.z + 0.7}, {x + 0.5, floor + 1.0, hi.z - 0.7}, goods);
    }
}

void draw_well(Canvas& canvas, const Vec2& center_m) {
    const Vec2 half(1.2);
    const double floor = floor_above_ground(canvas, center_m - half, 2.0 * half);
    const Vec3 lo(center_m.x - half.x, floor - 1.0, center_m.y - half.y);
    const Vec3 hi(center_m.x + half.x, floor + 0.9, center_m.y + half.y);
    draw_walls(canvas, {lo, hi}, {}, [](const IVec3&) { return Paint{palette::kMasonry, 0.2}; });
    canvas.box({lo.x, floor, lo.z}, {hi.x, floor + 0.2, hi.z},
               {palette::kWater, 0.1, Layer::kRock});
    const Paint wood{palette::kTimberDark, 0.15};
    for (const double x : {lo.x + 0.1, hi.x - 0.1}) {
        canvas.limb({x, floor, center_m.y}, {x, floor + 2.4, center_m.y}, {0.05, 0.05}, wood);
    }
    canvas.box({lo.x - 0.3, floor + 2.4, lo.z}, {hi.x + 0.3, floor + 2.65, hi.z}, wood);
}

void draw_cabin(Canvas& canvas, House house) {
    RandomStream& random = house.random;
    const double wall_top = house.floor_m + 2.6;
    const Box room{
        {house.corner_m.x, house.floor_m, house.corner_m.y},
        {house.corner_m.x + house.extent_m.x, wall_top, house.corner_m.y + house.extent_m.y}};
    const Rgb logs = mix(palette::kTimber, palette::kTimberDark, random.uniform());
    const auto log_wall = [&](const IVec3& v) {
        return Paint{logs * (v.y % 2 == 0 ? 1.15f : 0.8f), 0.12};
    };
    Box walls = room;
    walls.lo.y -= kFoundation_m;
    draw_walls(canvas, walls, windows_of(room, random, house.door, true), log_wall);
    canvas.box({room.lo.x, house.floor_m - canvas.voxel_m(), room.lo.z},
               {room.hi.x, house.floor_m, room.hi.z}, {palette::kTimber, 0.15});
    draw_lantern(canvas, 0.5 * (room.lo + room.hi));

    const double ridge_m = draw_gable_roof(canvas, house, room, random, log_wall);
    const Vec3 chimney(mix(room.lo.x, room.hi.x, 0.25), house.floor_m,
                       mix(room.lo.z, room.hi.z, 0.3));
    canvas.box(chimney - Vec3(0.4, 0.0, 0.4),
               chimney + Vec3(0.4, ridge_m + 1.0 - house.floor_m, 0.4), {palette::kMasonry, 0.2});
    // Panes glow in some windows.
    for (const Box& pane : windows_of(room, random, house.door, false)) {
        if (random.uniform() < 0.5 || !canvas.resolves(0.3)) continue;
        Vec3 at = glm::clamp(0.5 * (pane.lo + pane.hi), room.lo, room.hi - 0.6 * canvas.voxel_m());
        canvas.put(canvas.voxel_at(at), {palette::kThatch, 0.0, Layer::kLight, kWindowLight});
    }
}

void draw_tower(Canvas& canvas, const Tower& tower) {
    const Vec2 extent(tower.width_m);
    const Vec2 corner = tower.center_m - 0.5 * extent;
    const double floor = floor_above_ground(canvas, corner, extent);
    const Box shaft{{corner.x, floor, corner.y},
                    {corner.x + extent.x, floor + tower.height_m, corner.y + extent.y}};
    const auto stone = [&](const IVec3& v) { return masonry(canvas, v, tower.stone); };
    std::vector<Box> openings;
    openings.push_back(opening_in(shaft, Side::kSouth, 0.5, {1.2, 2.2}, 0.0));
    for (double y = 3.5; y < tower.height_m - 2.0; y += 3.5) {
        for (const Side side : kSides)
            openings.push_back(opening_in(shaft, side, 0.5, {0.5, 1.2}, y));
    }
    Box walls = shaft;
    walls.lo.y -= 2.0 * kFoundation_m;
    draw_walls(canvas, walls, openings, stone);
    // Battlements on a walk that stands out a little.
    const Box walk{{shaft.lo.x - 0.5, shaft.hi.y, shaft.lo.z - 0.5},
                   {shaft.hi.x + 0.5, shaft.hi.y + 1.2, shaft.hi.z + 0.5}};
    canvas.box(walk.lo - Vec3(0.0, canvas.voxel_m(), 0.0), {walk.hi.x, walk.lo.y, walk.hi.z},
               {tower.snow > 0.0 ? palette::kSnow : tower.stone, 0.08});
    std::vector<Box> gaps;
    for (double s = 0.75; s < extent.x + 1.0; s += 1.5) {
        for (const Side side : kSides) {
            gaps.push_back(opening_in(walk, side, s / (extent.x + 1.0), {0.7, 1.0}, 0.6));
        }
    }
    draw_walls(canvas, walk, gaps, stone);
    if (tower.beacon) {
        const Vec3 fire(tower.center_m.x, walk.lo.y, tower.center_m.y);
        canvas.box(fire - Vec3(0.4, 0.0, 0.4), fire + Vec3(0.4, 0.6, 0.4),
                   {palette::kTimberDark, 0.1});
        canvas.box(fire + Vec3(-0.25, 0.6, -0.25), fire + Vec3(0.25, 1.1, 0.25),
                   {Rgb(0.6f, 0.3f, 0.1f), 0.0, Layer::kLight, kLampLight * 2.0f});
    }
}

}  // namespace probebake::worldgen
