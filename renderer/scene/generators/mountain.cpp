// Mountain: ridges climbing to the north-east under snow, bare rock on the steepest faces; snowy
// conifers up to the tree line, smooth snow fields along a trough valley, a frozen lake with a
// hamlet in the south-west, a beacon tower on a shoulder (Müller 2020, 4.3).
#include <algorithm>
#include <cmath>
#include <memory>

#include "scene/generators/palette.h"
#include "scene/generators/random.h"
#include "scene/generators/river.h"
#include "scene/generators/soil.h"
#include "scene/generators/stands.h"
#include "scene/generators/structures.h"
#include "scene/generators/town.h"

namespace probebake::worldgen {
namespace {

constexpr double kLake_m = 38.0;
constexpr double kTreeLine_m = 128.0;
constexpr double kSnowLine_m = 20.0;  // below the lowest ground: snow lies wherever it holds
constexpr Vec2 kHamlet_m{186.0, 442.0};
constexpr Vec2 kTower_m{300.0, 330.0};

class Mountain {
  public:
    explicit Mountain(uint64_t seed);

    double height_m(const Vec2& at) const;
    Rgb color(const GroundPoint& p) const;

    void trees(Spot& spot, Canvas& canvas) const;
    void undergrowth(Spot& spot, Canvas& canvas) const;
    void boulders(Spot& spot, Canvas& canvas) const;
    void crags(Spot& spot, Canvas& canvas) const;
    void buildings(Canvas& canvas) const;

  private:
    double uplift_m(const Vec2& at) const;
    /// Distance from the edge of the flat trough, < 0 on it.
    double trough_edge_m(const Vec2& at) const;
    double trough_floor_m(const Vec2& at) const;
    double talus(const Vec2& at) const;
    double density(const Vec2& at, double height_m) const;

    Noise shape_;
    Noise detail_;
    Soil soil_;
    Curve trough_;
    Lake lake_;
    Hamlet hamlet_;
    Grid edge_m_;
    Grid eroded_m_;
};

Mountain::Mountain(uint64_t seed)
    : shape_(random_key({seed, 11})),
      detail_(random_key({seed, 12})),
      soil_(seed),
      trough_(jittered(
          {{-80, 520}, {60, 455}, {160, 400}, {225, 300}, {330, 235}, {385, 120}, {430, -80}},
          {16.0, 16.0}, random_key({seed, 13}))),
      lake_({{88.0, 442.0}, {58.0, 40.0}, kLake_m, 6.0}, random_key({seed, 14})),
      hamlet_(plan_hamlet(kHamlet_m, 24.0, 0.9, random_key({seed, 15}))),
      edge_m_(256, [this](const Vec2& at) { return trough_edge_m(at); }),
      eroded_m_(erode([this](const Vec2& at) { return uplift_m(at); },
                      {0.014, [this](const Vec2& at, double) { return talus(at); },
                       [this](const Vec2& at) { return edge_m_.sample(at) < 0.0; }})) {}

double Mountain::trough_edge_m(const Vec2& at) const {
    const double away = trough_.nearest(at, 120.0).distance_m;
    const double edge = away - 16.0 - 20.0 * shape_.fbm(at, {60.0, 3});
    return std::min(edge, hamlet_.from_center_m(at) - hamlet_.radius_m - 6.0);
}

double Mountain::trough_floor_m(const Vec2& at) const {
    const double along = trough_.nearest(at, 500.0).along;
    return kLake_m + 1.5 + 62.0 * smooth_step(0.25, 1.0, along);
}

double Mountain::uplift_m(const Vec2& at) const {
    const Vec2 p = at + 36.0 * shape_.warp(at, {150.0, 2});
    const double climb = 0.5 * (p.x / kWorldSide_m + 1.0 - p.y / kWorldSide_m);
    const double rise = smooth_step(0.1, 1.0, climb);
    const double ridges = shape_.ridged(p, {210.0, 4});
    const double peaks =
        44.0 + 74.0 * rise + (56.0 + 150.0 * rise) * ridges + 6.0 * shape_.fbm(at, {20.0, 3});
    const double away = std::max(0.0, edge_m_.sample(at));
    // A trough has a flat floor and walls that steepen upwards.
    return mix(trough_floor_m(at), peaks, smooth_step(0.0, 95.0, away));
}

double Mountain::talus(const Vec2& at) const {
    return std::max(0.45, 0.95 + 0.9 * shape_.fbm(at, {55.0, 4, 0.6}));
}

double Mountain::density(const Vec2& at, double height_m) const {
    const double stand = shape_.fbm(at, {90.0, 3});
    const double line = kTreeLine_m + 30.0 * stand;
    return smooth_step(-0.4, -0.1, stand) * smooth_step(line, line - 45.0, height_m) *
           smooth_step(-10.0, 12.0, edge_m_.sample(at) + 14.0 * shape_.at(at / 18.0));
}

double Mountain::height_m(const Vec2& at) const {
    const Vec2 p = at + 4.0 * detail_.warp(at, {24.0, 3});
    const double coarse = eroded_m_.sample(p);
    const double wild = smooth_step(-2.0, 14.0, edge_m_.sample(at));
    const double rough = smooth_step(-0.1, 0.4, shape_.fbm(at, {70.0, 3}));
    const double crag = detail_.ridged(at, {27.0, 5, 0.55}) - 0.4;
    const double rock = coarse + wild * (1.4 + 6.0 * rough) * crag;
    const double benches =
        ledges(rock + 2.0 * detail_.at(at / 13.0), 6.0 + 2.0 * shape_.at(at / 30.0));
    const double h = mix(rock, benches, 0.35 * wild * rough) +
                     (0.15 + 0.7 * wild) * detail_.fbm(at, {6.0, 4, 0.6});
    return lake_.cut(at, h);
}

Rgb Mountain::color(const GroundPoint& p) const {
    const Vec2 at = p.plan();
    if (lake_.depth_m(at) > 0.0) return soil_.ice(p);
    if (snow_lies(p, kSnowLine_m, soil_.mottle(at))) return soil_.snow(p);
    return soil_.granite(p);
}

void Mountain::trees(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (lake_.depth_m(at) > -0.5 || spot.slope > 1.5) return;
    if (hamlet_.from_center_m(at) < hamlet_.radius_m + 8.0) return;
    if (spot.random.uniform() > 0.9 * density(at, spot.foot_m.y)) return;
    Stand stand;
    stand.conifers = 0.9;
    stand.birches = 0.06;
    stand.autumn = 0.03;
    stand.dead = 0.03;
    stand.snow = between(spot.random, 0.35, 0.95);
    stand.stature = mix(1.35, 0.65, smooth_step(70.0, kTreeLine_m + 15.0, spot.foot_m.y));
    plant_tree(canvas, spot, stand);
}

void Mountain::undergrowth(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (lake_.depth_m(at) > 0.0 || spot.slope > 1.2 || hamlet_.distance_m(at) < 1.5) return;
    if (spot.random.uniform() < 0.3 * density(at, spot.foot_m.y)) {
        plant_undergrowth(canvas, spot, 0.9);
    }
}

void Mountain::boulders(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    const double chance = 0.06 + 0.3 * smooth_step(0.4, 1.2, spot.slope);
    if (spot.random.uniform() > chance || lake_.depth_m(at) > -0.5) return;
    if (hamlet_.from_center_m(at) < hamlet_.radius_m + 3.0) return;
    draw_boulders(canvas, spot, between(spot.random, 0.25, 1.1), true,
                  [&](const GroundPoint& p) { return soil_.granite(p); });
}

void Mountain::crags(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    const double chance = 0.5 * smooth_step(0.7, 1.5, spot.slope) + 0.04;
    if (spot.random.uniform() > chance || edge_m_.sample(at) < 4.0) return;
    draw_boulders(canvas, spot, between(spot.random, 1.2, 4.5), true,
                  [&](const GroundPoint& p) { return soil_.granite(p); });
}

void Mountain::buildings(Canvas& canvas) const {
    draw_hamlet(canvas, hamlet_);
    Tower tower;
    tower.center_m = kTower_m;
    tower.width_m = 7.0;
    tower.height_m = 16.0;
    tower.stone = palette::kMasonry;
    tower.beacon = true;
    tower.snow = 1.0;
    draw_tower(canvas, tower);
    draw_lookout(canvas, kHamlet_m + Vec2(58.0, 22.0), 15.0, 1.0);
    draw_flags(canvas, kHamlet_m + Vec2(-16.0, 6.0), kHamlet_m + Vec2(18.0, -4.0), 5.5);
}

}  // namespace

Landscape make_mountain(uint64_t seed) {
    const auto world = std::make_shared<const Mountain>(seed);
    Landscape landscape;
    landscape.height_m = [world](const Vec2& at) { return world->height_m(at); };
    landscape.color = [world](const GroundPoint& p) { return world->color(p); };
    landscape.scatters = {
        {3.25, 4.0, [world](Spot& s, Canvas& c) { world->trees(s, c); }},
        {3.0, 0.6, [world](Spot& s, Canvas& c) { world->undergrowth(s, c); }},
        {3.0, 0.5, [world](Spot& s, Canvas& c) { world->boulders(s, c); }},
        {15.0, 2.0, [world](Spot& s, Canvas& c) { world->crags(s, c); }},
    };
    landscape.structures = {[world](Canvas& c) { world->buildings(c); }};
    return landscape;
}

}  // namespace probebake::worldgen
