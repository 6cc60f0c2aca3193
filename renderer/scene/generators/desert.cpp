// Desert: a sandstone plateau with mesas, cut by a canyon whose floor holds a river, palms and a
// walled town; dunes in the south-west, a dark wood below a rough mountain in the north-east, an
// aqueduct across the valley, a ruined temple on the plateau (Müller 2020, 4.1).
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

constexpr double kPlateau_m = 96.0;
constexpr double kTownShare = 0.45;  // along the valley
constexpr double kDryFoliage = 0.5;  // crowns are thin here
constexpr Vec2 kMountain_m{440.0, 70.0};
constexpr Vec2 kDarkWood_m{352.0, 128.0};
constexpr Vec2 kDunes_m{60.0, 475.0};

class Desert {
  public:
    explicit Desert(uint64_t seed);

    double height_m(const Vec2& at) const;
    Rgb color(const GroundPoint& p) const;

    void palms(Spot& spot, Canvas& canvas) const;
    void dark_wood(Spot& spot, Canvas& canvas) const;
    void acacias(Spot& spot, Canvas& canvas) const;
    void junipers(Spot& spot, Canvas& canvas) const;
    void shrubs(Spot& spot, Canvas& canvas) const;
    void straw(Spot& spot, Canvas& canvas) const;
    void stones(Spot& spot, Canvas& canvas) const;
    void rocks(Spot& spot, Canvas& canvas) const;
    void buildings(Canvas& canvas, uint64_t key) const;
    void aqueduct(Canvas& canvas) const;

  private:
    double floor_m(const Vec2& at) const { return 45.0 - 0.008 * at.x; }
    /// Distance from the edge of the valley's flat floor, < 0 on it.
    double valley_edge_m(const Vec2& at) const;
    /// Follows the valley, past the south wall of the town.
    std::vector<Vec2> river_course() const;
    double talus(const Vec2& at, double height_m) const;
    double uplift_m(const Vec2& at) const;
    double dunes_m(const Vec2& at) const;
    /// 1 beside the river, 0 from some 40 m on.
    double green(const Vec2& at) const;
    double dark_wood_share(const Vec2& at) const;
    bool built_or_wet(const Vec2& at, double margin_m) const {
        return town_.distance_m(at) < margin_m || river_.depth_m(at) > -0.3;
    }

    Noise shape_;
    Noise detail_;
    Soil soil_;
    Curve valley_;
    Town town_;
    River river_;
    Grid edge_m_;
    Grid eroded_m_;
};

Desert::Desert(uint64_t seed)
    : shape_(random_key({seed, 31})),
      detail_(random_key({seed, 32})),
      soil_(seed),
      valley_(jittered({{-90, 350}, {70, 330}, {190, 300}, {320, 300}, {430, 250}, {610, 225}},
                       {8.0, 12.0}, random_key({seed, 33}))),
      town_{valley_.at(kTownShare) + Vec2(0.0, -22.0), {94.0, 44.0}},
      river_({river_course(), 4.2, 44.6, 39.5}, random_key({seed, 34})),
      edge_m_(256, [this](const Vec2& at) { return valley_edge_m(at); }),
      eroded_m_(erode([this](const Vec2& at) { return uplift_m(at); },
                      {0.008, [this](const Vec2& at, double h) { return talus(at, h); },
                       [this](const Vec2& at) { return edge_m_.sample(at) < 0.0; }})) {}

std::vector<Vec2> Desert::river_course() const {
    const Vec2 south = town_.center_m + Vec2(0.0, town_.half_m.y + 19.0);
    return {valley_.at(0.0), valley_.at(0.14),         south + Vec2(-90.0, -4.0),
            south,           south + Vec2(90.0, -7.0), valley_.at(0.78),
            valley_.at(1.0)};
}

double Desert::valley_edge_m(const Vec2& at) const {
    const Curve::Nearest n = valley_.nearest(at, 500.0);
    const double bulge = smooth_step(0.27, 0.0, std::abs(n.along - kTownShare));
    const double edge = n.distance_m - 22.0 - 52.0 * bulge - 9.0 * shape_.fbm(at, {55.0, 3});
    return std::min(edge, town_.distance_m(at) - 5.0);
}

/// Hard beds make cliffs, soft ones slopes.
double Desert::talus(const Vec2& at, double height_m) const {
    const double bed = shape_.at(Vec2((height_m + 3.0 * shape_.at(at / 80.0)) / 12.0, 0.5));
    return mix(0.6, 5.0, smooth_step(-0.1, 0.1, bed));
}

double Desert::uplift_m(const Vec2& at) const {
    const double away = edge_m_.sample(at);
    const Vec2 p = at + 26.0 * shape_.warp(at, {90.0, 3});
    const double mesas =
        44.0 * smooth_step(0.10, 0.17, shape_.fbm(p, {130.0, 3})) * smooth_step(30.0, 60.0, away);
    const double peak = 1.0 - glm::length(p - kMountain_m) / 130.0;
    const double heights = peak > 0.0 ? 90.0 * peak * (0.4 + shape_.ridged(at, {60.0, 4})) : 0.0;
    const double plateau = kPlateau_m + 6.0 * shape_.fbm(at, {120.0, 3}) + mesas + heights;
    const double rim = 0.45 * smooth_step(0.0, 20.0, away) + 0.55 * smooth_step(22.0, 48.0, away);
    return mix(floor_m(at) + 1.0, plateau, rim);
}

double Desert::dunes_m(const Vec2& at) const {
    const double reach = glm::length(at - kDunes_m) + 30.0 * shape_.at(at / 70.0);
    const double region = smooth_step(190.0, 120.0, reach);
    if (!(region > 0.0)) return 0.0;
    const Vec2 bent = at + 9.0 * detail_.warp(at, {60.0, 2});
    const Vec2 crest(bent.x * 0.35 + bent.y * 0.25, bent.y - 0.5 * bent.x);
    return region * 10.0 * shape_.ridged(crest, {44.0, 2, 0.3});
}

double Desert::green(const Vec2& at) const {
    if (edge_m_.sample(at) > 0.0) return 0.0;
    const double away = river_.curve().nearest(at, 60.0).distance_m;
    return smooth_step(48.0, 14.0, away + 10.0 * shape_.at(at / 15.0));
}

double Desert::dark_wood_share(const Vec2& at) const {
    const Vec2 stretched = (at - kDarkWood_m) * Vec2(0.8, 1.15);
    return smooth_step(104.0, 82.0, glm::length(stretched) + 22.0 * shape_.fbm(at, {50.0, 3}));
}

double Desert::height_m(const Vec2& at) const {
    const Vec2 p = at + 3.0 * detail_.warp(at, {17.0, 3});
    const double coarse = eroded_m_.sample(p);
    const double dunes = dunes_m(at);
    const double rough =
        smooth_step(1.5, 8.0, coarse - floor_m(at)) * (1.0 - smooth_step(0.0, 1.5, dunes));
    const double peak = smooth_step(140.0, 60.0, glm::length(at - kMountain_m));
    const double rubble = smooth_step(-0.15, 0.3, soil_.patches(at));
    const double h = coarse + dunes +
                     rough * (0.6 + 2.8 * peak) * (detail_.ridged(at, {14.0, 5, 0.6}) - 0.35) +
                     (0.10 + rough * (0.5 + 0.9 * rubble)) * detail_.fbm(at, {3.2, 3, 0.8});
    return river_.cut(at, h);
}

Rgb Desert::color(const GroundPoint& p) const {
    const Vec2 at = p.plan();
    const double depth = river_.depth_m(at);
    if (depth > 0.0) return soil_.water(p, depth);
    const double mottle = soil_.mottle(at);
    if (p.slope + 0.35 * mottle > 0.85 || p.depth_m > 0.8) return soil_.sandstone(p);
    if (town_.distance_m(at) < 0.0) {
        return town_.in_street(at) ? soil_.path(p) : mix(soil_.path(p), palette::kSand, 0.5);
    }
    const double grows = green(at);
    if (grows + 0.25 * mottle > 0.45) return soil_.grass(p, 1.15 - grows);
    if (dunes_m(at) > 0.8 + 0.5 * mottle) return soil_.sand(p);
    if (dark_wood_share(at) + 0.3 * mottle > 0.5) {
        return mix(soil_.forest_floor(p), palette::kSand, 0.15);
    }
    const double bare = soil_.patches(at) + 0.5 * mottle;
    if (bare > 0.25) return mix(soil_.sandstone(p), palette::kSand, 0.35);
    return bare < -0.2 ? soil_.sand(p) : soil_.gravel(p);
}

void Desert::palms(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (built_or_wet(at, 3.0) || spot.random.uniform() > 0.75 * green(at)) return;
    if (spot.random.uniform() < 0.75) {
        const double tall = between(spot.random, 5.5, 12.5);
        draw_palm(canvas, plant_at(spot, palette::kPalm, palette::kBark, tall, kDryFoliage));
    } else {
        const double tall = between(spot.random, 1.0, 2.5);
        draw_bush(canvas, plant_at(spot, palette::kAcacia, palette::kBark, tall));
    }
}

void Desert::dark_wood(Spot& spot, Canvas& canvas) const {
    if (spot.slope > 1.4 || spot.random.uniform() > 0.9 * dark_wood_share(spot.plan())) return;
    const double tall = between(spot.random, 12.0, 25.0);
    if (spot.random.uniform() < 0.35) {
        draw_cypress(canvas, plant_at(spot, palette::kSpruce, palette::kBark, tall, kDryFoliage));
    } else {
        draw_spruce(canvas, plant_at(spot, palette::kSpruce, palette::kBark, tall, kDryFoliage));
    }
}

void Desert::acacias(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (spot.slope > 0.6 || built_or_wet(at, 6.0) || dunes_m(at) > 1.0) return;
    if (spot.random.uniform() > 0.5) return;
    const double tall = between(spot.random, 5.0, 9.5);
    draw_acacia(canvas, plant_at(spot, palette::kAcacia, palette::kBark, tall, kDryFoliage));
}

void Desert::junipers(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (spot.slope > 1.3 || built_or_wet(at, 8.0) || dunes_m(at) > 0.5 || green(at) > 0.3) return;
    const double chance = 0.75 * smooth_step(0.0, 0.3, detail_.fbm(at, {70.0, 3}));
    if (spot.random.uniform() > chance) return;
    const double tall = between(spot.random, 3.5, 8.5);
    if (spot.random.uniform() < 0.12) {
        draw_dead_tree(canvas, plant_at(spot, palette::kDeadWood, palette::kDeadWood, tall));
    } else {
        draw_broadleaf(canvas,
                       plant_at(spot, palette::kJuniper, palette::kDeadWood, tall, kDryFoliage));
    }
}

void Desert::shrubs(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (spot.slope > 0.9 || built_or_wet(at, 2.0) || dunes_m(at) > 1.0) return;
    const double chance = 0.45 + 0.6 * soil_.patches(at) - 0.3 * green(at);
    if (spot.random.uniform() < chance) plant_desert_shrub(canvas, spot);
}

void Desert::straw(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    const double lush = green(at);
    if (spot.random.uniform() > 0.15 + 0.4 * soil_.patches(at) + 0.5 * lush) return;
    if (built_or_wet(at, 1.0) || dunes_m(at) > 1.0) return;
    plant_meadow(canvas, spot, 1.0 - 0.8 * lush, 1.2);
}

void Desert::stones(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (spot.random.uniform() > 0.45 || built_or_wet(at, 1.0) || dunes_m(at) > 1.0) return;
    if (spot.random.uniform() < green(at)) return;
    const double radius = between(spot.random, 0.15, 0.65);
    draw_boulders(canvas, spot, radius, false,
                  [&](const GroundPoint& p) { return soil_.sandstone(p); });
}

void Desert::rocks(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    const double field = smooth_step(0.0, 0.25, shape_.fbm(at, {48.0, 3}));
    const double chance = 0.08 + 0.5 * field + 0.3 * smooth_step(0.3, 1.0, spot.slope);
    if (spot.random.uniform() > chance || built_or_wet(at, 6.0) || dunes_m(at) > 2.0) return;
    const double radius = between(spot.random, 0.7, 1.45);
    draw_boulders(canvas, spot, radius * radius * radius + 0.3, false,
                  [&](const GroundPoint& p) { return soil_.sandstone(p); });
}

void Desert::aqueduct(Canvas& canvas) const {
    Aqueduct aqueduct;
    aqueduct.from_m = valley_.at(0.2) - Vec2(0.0, 90.0);
    aqueduct.length_m = 180.0;
    aqueduct.level_m = kPlateau_m - 14.0;
    aqueduct.stone = palette::kSandstonePale;
    draw_aqueduct(canvas, aqueduct);
}

void Desert::buildings(Canvas& canvas, uint64_t key) const {
    draw_town(canvas, town_, key);
    draw_temple_ruin(canvas, {385.0, 400.0}, RandomStream(random_key({key, 1})));
}

}  // namespace

Landscape make_desert(uint64_t seed) {
    const auto world = std::make_shared<const Desert>(seed);
    Landscape landscape;
    landscape.height_m = [world](const Vec2& at) { return world->height_m(at); };
    landscape.color = [world](const GroundPoint& p) { return world->color(p); };
    landscape.scatters = {
        {4.2, 2.0, [world](Spot& s, Canvas& c) { world->palms(s, c); }},
        {2.4, 2.0, [world](Spot& s, Canvas& c) { world->dark_wood(s, c); }},
        {16.0, 2.0, [world](Spot& s, Canvas& c) { world->acacias(s, c); }},
        {6.5, 1.5, [world](Spot& s, Canvas& c) { world->junipers(s, c); }},
        {2.6, 0.4, [world](Spot& s, Canvas& c) { world->shrubs(s, c); }},
        {1.1, 0.25, [world](Spot& s, Canvas& c) { world->straw(s, c); }},
        {3.0, 0.3, [world](Spot& s, Canvas& c) { world->stones(s, c); }},
        {5.5, 1.0, [world](Spot& s, Canvas& c) { world->rocks(s, c); }},
    };
    landscape.structures = {
        [world, seed](Canvas& c) {
            world->buildings(c, random_key({seed, 35}));
        },
        [world](Canvas& c) { world->aqueduct(c); },
    };
    return landscape;
}

}  // namespace probebake::worldgen
