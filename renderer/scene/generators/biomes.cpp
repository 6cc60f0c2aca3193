// Biomes: a snowy mountain in the north-east, snow-covered red rock in the north-west, desert in
// the south-west and forest in the south-east around a lake; their borders mix voxel by voxel
// (Müller 2020, 4.4).
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

constexpr double kLake_m = 44.0;
constexpr Vec2 kLakeCenter_m{262.0, 268.0};
constexpr Vec2 kTown_m{116.0, 380.0};
constexpr Vec2 kHamlet_m{352.0, 318.0};

class Biomes {
  public:
    explicit Biomes(uint64_t seed);

    double height_m(const Vec2& at) const;
    Rgb color(const GroundPoint& p) const;

    void trees(Spot& spot, Canvas& canvas) const;
    void shrubs(Spot& spot, Canvas& canvas) const;
    void boulders(Spot& spot, Canvas& canvas) const;
    void buildings(Canvas& canvas, uint64_t key) const;

  private:
    /// What the place is, each 0 to 1: arid (west) and cold (north) make the four biomes.
    struct Climate {
        double arid;
        double cold;
    };
    Climate climate(const Vec2& at) const {
        return {std::clamp(arid_.sample(at), 0.0, 1.0), std::clamp(cold_.sample(at), 0.0, 1.0)};
    }
    /// Where the place lies on the map of climates, both 0 to 1.
    Vec2 map_position(const Vec2& at) const {
        return (at + 45.0 * shape_.warp(at, {130.0, 3})) / kWorldSide_m;
    }
    double uplift_m(const Vec2& at) const;
    double talus(const Vec2& at, double height_m) const;
    double water_m(const Vec2& at) const;
    /// Distance from what people keep flat and free.
    double settled_m(const Vec2& at) const;
    bool snowy(const GroundPoint& p) const;

    Noise shape_;
    Noise detail_;
    Soil soil_;
    Grid arid_;
    Grid cold_;
    Lake lake_;
    River inflow_;
    River outflow_;
    Town town_;
    Hamlet hamlet_;
    Grid eroded_m_;
};

Biomes::Biomes(uint64_t seed)
    : shape_(random_key({seed, 41})),
      detail_(random_key({seed, 42})),
      soil_(seed),
      arid_(256, [this](const Vec2& at) { return smooth_step(0.54, 0.44, map_position(at).x); }),
      cold_(256, [this](const Vec2& at) { return smooth_step(0.47, 0.35, map_position(at).y); }),
      lake_({kLakeCenter_m, {62.0, 44.0}, kLake_m, 7.0}, random_key({seed, 43})),
      inflow_({jittered({{330, -90}, {345, 40}, {310, 130}, {285, 200}, kLakeCenter_m},
                        {12.0, 12.0}, random_key({seed, 44})),
               3.0, 66.0, kLake_m},
              random_key({seed, 45})),
      outflow_({jittered({kLakeCenter_m, {255, 350}, {285, 430}, {262, 600}}, {12.0, 12.0},
                         random_key({seed, 46})),
                3.8, kLake_m, 40.0},
               random_key({seed, 47})),
      town_{kTown_m, {62.0, 40.0}},
      hamlet_(plan_hamlet(kHamlet_m, 22.0, 0.0, random_key({seed, 48}))),
      eroded_m_(
          erode([this](const Vec2& at) { return uplift_m(at); },
                {0.012, [this](const Vec2& at, double h) { return talus(at, h); },
                 [this](const Vec2& at) { return settled_m(at) < 4.0 || water_m(at) > -3.0; }})) {}

double Biomes::water_m(const Vec2& at) const {
    return std::max({lake_.depth_m(at), inflow_.depth_m(at), outflow_.depth_m(at)});
}

double Biomes::settled_m(const Vec2& at) const {
    return std::min(town_.distance_m(at), hamlet_.from_center_m(at) - hamlet_.radius_m - 4.0);
}

double Biomes::talus(const Vec2& at, double height_m) const {
    const double bed = shape_.at(Vec2((height_m + 2.0 * shape_.at(at / 70.0)) / 10.0, 0.5));
    const double arid = mix(0.6, 4.5, smooth_step(-0.1, 0.1, bed));
    return mix(0.9 + 0.8 * shape_.fbm(at, {50.0, 3, 0.6}), arid, climate(at).arid);
}

double Biomes::uplift_m(const Vec2& at) const {
    const Climate c = climate(at);
    const Vec2 p = at + 28.0 * shape_.warp(at, {110.0, 2});
    const double ridges = shape_.ridged(p, {170.0, 4});
    const double mesas = smooth_step(0.04, 0.12, shape_.fbm(p, {120.0, 3}));
    const double green = 8.0 + 34.0 * ridges + c.cold * (18.0 + 105.0 * ridges);
    const double arid =
        7.0 + 8.0 * shape_.fbm(at, {60.0, 3}) + (30.0 + 24.0 * c.cold) * mesas + 14.0 * c.cold;
    const double away = std::min(settled_m(at), 60.0 * (lake_.from_center(at) - 1.05));
    const double river = std::min(inflow_.curve().nearest(at, 60.0).distance_m,
                                  outflow_.curve().nearest(at, 60.0).distance_m);
    const double inland = smooth_step(0.0, 60.0, away) * smooth_step(6.0, 50.0, river);
    const double north = smooth_step(260.0, 0.0, at.y);
    return kLake_m + 2.0 + 20.0 * north + inland * mix(green, arid, c.arid);
}

double Biomes::height_m(const Vec2& at) const {
    const Climate c = climate(at);
    const Vec2 p = at + 3.5 * detail_.warp(at, {20.0, 3});
    const double coarse = eroded_m_.sample(p);
    const double wild = smooth_step(0.0, 14.0, settled_m(at));
    const double rough = smooth_step(-0.1, 0.4, shape_.fbm(at, {65.0, 3}));
    const double crag = detail_.ridged(at, {20.0, 5, 0.55}) - 0.4;
    const double dunes =
        c.arid * (1.0 - c.cold) * smooth_step(0.15, -0.1, shape_.fbm(at, {120.0, 3}));
    const double h = coarse +
                     wild * ((0.8 + 3.6 * rough * mix(0.4, 1.0, c.cold)) * crag +
                             4.0 * dunes * shape_.ridged(at, {32.0, 2, 0.3})) +
                     (0.12 + 0.4 * wild * (1.0 - dunes)) * detail_.fbm(at, {5.0, 4, 0.6});
    return lake_.cut(at, inflow_.cut(at, outflow_.cut(at, h)));
}

bool Biomes::snowy(const GroundPoint& p) const {
    const double cold = climate(p.plan()).cold;
    const double line = mix(190.0, 40.0, cold);
    return cold > 0.05 && snow_lies(p, line, soil_.mottle(p.plan()));
}

Rgb Biomes::color(const GroundPoint& p) const {
    const Vec2 at = p.plan();
    const double depth = water_m(at);
    if (depth > 0.0) return soil_.water(p, depth);
    const Climate c = climate(at);
    const double mottle = soil_.mottle(at);
    if (town_.distance_m(at) < 0.0) {
        return town_.in_street(at) ? soil_.path(p) : mix(soil_.path(p), palette::kSand, 0.5);
    }
    if (snowy(p)) return soil_.snow(p);
    const bool arid = c.arid + 0.3 * mottle + 0.4 * (p.hash - 0.5) > 0.5;
    const bool steep = p.slope + 0.35 * mottle > (arid ? 0.85 : 1.0) || p.depth_m > 0.8;
    if (steep) return arid ? soil_.sandstone(p) : soil_.granite(p);
    if (depth > -0.9) return mix(soil_.path(p), palette::kGravel, 0.7);
    if (arid) return soil_.patches(at) + 0.5 * mottle > 0.1 ? soil_.gravel(p) : soil_.sand(p);
    const double dry = 0.15 + 0.5 * c.arid + (p.at_m.y - 60.0) / 120.0;
    return soil_.patches(at) + 0.4 * mottle > -0.1 ? soil_.forest_floor(p) : soil_.grass(p, dry);
}

void Biomes::trees(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (water_m(at) > -0.6 || spot.slope > 1.3 || settled_m(at) < 5.0) return;
    const Climate c = climate(at);
    if (c.arid > 0.5) {
        const double oasis = smooth_step(1.45, 1.1, lake_.from_center(at));
        const double choice = spot.random.uniform();
        if (c.cold < 0.3 && choice < 0.35 * oasis) {
            const double tall = between(spot.random, 5.0, 10.0);
            draw_palm(canvas, plant_at(spot, palette::kPalm, palette::kBark, tall));
        } else if (c.cold < 0.5 && choice < 0.012) {
            const double tall = between(spot.random, 5.0, 8.0);
            draw_acacia(canvas, plant_at(spot, palette::kAcacia, palette::kBark, tall));
        } else if (c.cold >= 0.5 && choice < 0.05) {
            Plant tree =
                plant_at(spot, palette::kPine, palette::kBarkPine, between(spot.random, 8.0, 15.0));
            tree.snow = 0.6;
            draw_pine(canvas, tree);
        }
        return;
    }
    const double stand_share = smooth_step(-0.25, 0.1, soil_.patches(at)) * (1.0 - 1.2 * c.arid);
    const double line = smooth_step(135.0, 105.0, spot.foot_m.y);
    if (spot.random.uniform() > 0.85 * stand_share * line) return;
    Stand stand;
    stand.conifers = mix(0.35, 0.93, c.cold);
    stand.birches = mix(0.2, 0.04, c.cold);
    stand.autumn = 0.14;
    stand.foliage = 0.75;
    stand.snow = 0.7 * c.cold;
    stand.stature = mix(1.15, 0.7, smooth_step(80.0, 125.0, spot.foot_m.y));
    plant_tree(canvas, spot, stand);
}

void Biomes::shrubs(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (water_m(at) > -0.2 || spot.slope > 1.0 || town_.distance_m(at) < 2.0) return;
    if (hamlet_.distance_m(at) < 0.8) return;
    const Climate c = climate(at);
    const double choice = spot.random.uniform();
    if (c.arid > 0.5) {
        if (c.cold < 0.5 && choice < 0.2) plant_desert_shrub(canvas, spot);
        if (c.cold < 0.5 && choice > 0.6) plant_meadow(canvas, spot, 1.0, 1.2);
    } else if (choice < 0.1) {
        if (settled_m(at) > 4.0) plant_undergrowth(canvas, spot, c.cold > 0.5 ? 0.8 : 0.0);
    } else if (choice < 0.65 && c.cold < 0.4) {
        plant_meadow(canvas, spot, 0.3 + 0.5 * soil_.patches(at), 0.8);
    }
}

void Biomes::boulders(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    const double chance = 0.08 + 0.3 * smooth_step(0.4, 1.2, spot.slope);
    if (spot.random.uniform() > chance || water_m(at) > -0.2 || settled_m(at) < 3.0) return;
    const Climate c = climate(at);
    const double size = between(spot.random, 0.5, 1.3);
    draw_boulders(canvas, spot, size * size * size + 0.2, c.cold > 0.5, [&](const GroundPoint& p) {
        return c.arid > 0.5 ? soil_.sandstone(p) : soil_.granite(p);
    });
}

void Biomes::buildings(Canvas& canvas, uint64_t key) const {
    draw_town(canvas, town_, key);
    draw_hamlet(canvas, hamlet_);
    Tower tower;
    tower.center_m = {400.0, 150.0};
    tower.width_m = 7.0;
    tower.height_m = 16.0;
    tower.stone = palette::kMasonry;
    tower.beacon = true;
    tower.snow = 1.0;
    draw_tower(canvas, tower);
    draw_lookout(canvas, kHamlet_m + Vec2(52.0, 18.0), 17.0, 0.0);
    draw_temple_ruin(canvas, {84.0, 190.0}, RandomStream(random_key({key, 1})));
    draw_river_bridge(canvas, outflow_, 0.45, 2.6);
}

}  // namespace

Landscape make_biomes(uint64_t seed) {
    const auto world = std::make_shared<const Biomes>(seed);
    Landscape landscape;
    landscape.height_m = [world](const Vec2& at) { return world->height_m(at); };
    landscape.color = [world](const GroundPoint& p) { return world->color(p); };
    landscape.scatters = {
        {3.8, 4.0, [world](Spot& s, Canvas& c) { world->trees(s, c); }},
        {1.0, 0.4, [world](Spot& s, Canvas& c) { world->shrubs(s, c); }},
        {3.6, 0.5, [world](Spot& s, Canvas& c) { world->boulders(s, c); }},
    };
    landscape.structures = {[world, seed](Canvas& c) {
        world->buildings(c, random_key({seed, 49}));
    }};
    return landscape;
}

}  // namespace probebake::worldgen
