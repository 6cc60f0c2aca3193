// Forest: a river valley under dense mixed woods; conifers and rock walls higher up, snow on the
// northern heights; a hamlet by a bridge, meadows, a lookout, a slackline between two trees
// (Müller 2020, 4.2 and figure 3.7).
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

constexpr double kSnowLine_m = 108.0;
constexpr double kBridge = 0.46;  // share of the river above the bridge

class Forest {
  public:
    explicit Forest(uint64_t seed);

    double height_m(const Vec2& at) const;
    Rgb color(const GroundPoint& p) const;

    void trees(Spot& spot, Canvas& canvas) const;
    void undergrowth(Spot& spot, Canvas& canvas) const;
    void meadow(Spot& spot, Canvas& canvas) const;
    void boulders(Spot& spot, Canvas& canvas) const;
    void tors(Spot& spot, Canvas& canvas) const;
    void buildings(Canvas& canvas) const;
    void slackline(Canvas& canvas, uint64_t key) const;

  private:
    /// Distance from the edge of the valley's flat floor, < 0 on it.
    double valley_edge_m(const Vec2& at) const;
    double uplift_m(const Vec2& at) const;
    double talus(const Vec2& at) const;
    /// Where rock stands out, 0 to 1.
    double rocky(const Vec2& at) const {
        return smooth_step(0.05, 0.35, shape_.fbm(at, {75.0, 3}));
    }
    /// How densely trees stand, 0 to 1.
    double density(const Vec2& at) const;

    Noise shape_;
    Noise detail_;
    Soil soil_;
    River river_;
    Hamlet hamlet_;
    Grid edge_m_;
    Grid eroded_m_;
};

Forest::Forest(uint64_t seed)
    : shape_(random_key({seed, 21})),
      detail_(random_key({seed, 22})),
      soil_(seed),
      river_(
          {jittered(
               {{120, -80}, {150, 50}, {225, 140}, {205, 255}, {285, 330}, {330, 440}, {360, 600}},
               {18.0, 18.0}, random_key({seed, 23})),
           4.6, 44.0, 35.0},
          random_key({seed, 24})),
      hamlet_(plan_hamlet(river_.curve().at(kBridge) + Vec2(46.0, -6.0), 27.0, 0.0,
                          random_key({seed, 25}))),
      edge_m_(256, [this](const Vec2& at) { return valley_edge_m(at); }),
      eroded_m_(erode([this](const Vec2& at) { return uplift_m(at); },
                      {0.016, [this](const Vec2& at, double) { return talus(at); },
                       [this](const Vec2& at) { return edge_m_.sample(at) < 0.0; }})) {}

double Forest::valley_edge_m(const Vec2& at) const {
    const double away = river_.curve().nearest(at, 400.0).distance_m;
    return std::min(hamlet_.from_center_m(at) - hamlet_.radius_m - 8.0,
                    away - 13.0 - 10.0 * shape_.at(at / 60.0));
}

double Forest::uplift_m(const Vec2& at) const {
    const double floor = river_.level_m(river_.curve().nearest(at, 400.0).along) + 1.2;
    const double away = std::max(0.0, edge_m_.sample(at));
    const double north = smooth_step(430.0, 0.0, at.y);
    const Vec2 p = at + 30.0 * shape_.warp(at, {140.0, 2});
    const double rise = smooth_step(0.0, 230.0, away);
    const double hills = (12.0 + 62.0 * rise + 75.0 * north * rise) * shape_.ridged(p, {190.0, 4});
    return floor + 0.1 * away + rise * (34.0 + 48.0 * north) + smooth_step(0.0, 60.0, away) * hills;
}

double Forest::talus(const Vec2& at) const {
    return 0.62 + rocky(at) * std::max(0.0, 1.6 + 2.6 * detail_.fbm(at, {26.0, 3, 0.7}));
}

double Forest::density(const Vec2& at) const {
    const double clearing = smooth_step(0.2, 0.3, detail_.fbm(at, {85.0, 3}));
    const double green =
        smooth_step(hamlet_.radius_m + 4.0, hamlet_.radius_m + 20.0, hamlet_.from_center_m(at));
    return (1.0 - clearing) * green;
}

double Forest::height_m(const Vec2& at) const {
    const Vec2 p = at + 3.5 * detail_.warp(at, {22.0, 2});
    const double coarse = eroded_m_.sample(p);
    const double wild = smooth_step(0.0, 14.0, coarse - 46.0);
    const double crag = detail_.ridged(at, {24.0, 5, 0.55}) - 0.35;
    const double rock = coarse + wild * (0.8 + 6.5 * rocky(at)) * crag;
    const double benches = ledges(rock, 4.5 + 1.5 * shape_.at(at / 25.0));
    const double h = mix(rock, benches, 0.8 * wild * rocky(at)) +
                     (0.12 + 0.45 * wild) * detail_.fbm(at, {7.0, 4, 0.6});
    return river_.cut(at, h);
}

Rgb Forest::color(const GroundPoint& p) const {
    const Vec2 at = p.plan();
    const double depth = river_.depth_m(at);
    if (depth > 0.0) return soil_.water(p, depth);
    const double mottle = soil_.mottle(at);
    if (snow_lies(p, kSnowLine_m, mottle)) return soil_.snow(p);
    if (p.slope + 0.3 * mottle > 1.05 || p.depth_m > 1.0) return soil_.granite(p);
    if (depth > -1.4 && p.slope < 0.6) return mix(soil_.path(p), palette::kGravel, 0.7);
    if (density(at) + 0.3 * mottle > 0.5) return soil_.forest_floor(p);
    return soil_.grass(p, 0.1 + (p.at_m.y - 50.0) / 130.0);
}

void Forest::trees(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (river_.depth_m(at) > -0.6 || spot.slope > 1.4) return;
    if (spot.random.uniform() > 0.9 * density(at)) return;
    const double altitude = spot.foot_m.y + 16.0 * soil_.patches(at);
    Stand stand;
    stand.conifers = 0.25 + 0.7 * smooth_step(45.0, 85.0, altitude);
    stand.birches = 0.45 * (1.0 - stand.conifers);
    stand.autumn = 0.15;
    stand.stature = mix(1.2, 0.65, smooth_step(95.0, 160.0, altitude));
    stand.snow = 0.65 * smooth_step(kSnowLine_m - 12.0, kSnowLine_m + 6.0, altitude);
    plant_tree(canvas, spot, stand);
}

void Forest::undergrowth(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (river_.depth_m(at) > -0.6 || spot.slope > 1.2 || hamlet_.distance_m(at) < 2.0) return;
    if (spot.random.uniform() > 0.06 + 0.5 * density(at)) return;
    plant_undergrowth(canvas, spot, spot.foot_m.y > kSnowLine_m ? 0.7 : 0.0);
}

void Forest::meadow(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (river_.depth_m(at) > -0.3 || spot.slope > 0.9 || hamlet_.distance_m(at) < 0.8) return;
    if (spot.foot_m.y > kSnowLine_m - 6.0) return;
    if (spot.random.uniform() > 0.55 - 0.3 * density(at)) return;
    plant_meadow(canvas, spot, 0.3 + 0.5 * soil_.patches(at), 0.6);
}

void Forest::boulders(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    const double chance = 0.08 + 0.5 * smooth_step(0.5, 1.2, spot.slope);
    if (spot.random.uniform() > chance || density(at) < 0.1 || river_.depth_m(at) > 0.0) return;
    const double size = between(spot.random, 0.55, 1.3);
    draw_boulders(canvas, spot, size * size * size, spot.foot_m.y > kSnowLine_m,
                  [&](const GroundPoint& p) { return soil_.granite(p); });
}

void Forest::tors(Spot& spot, Canvas& canvas) const {
    const Vec2 at = spot.plan();
    if (spot.random.uniform() > 0.6 * rocky(at) || edge_m_.sample(at) < 12.0) return;
    draw_boulders(canvas, spot, between(spot.random, 2.0, 6.0), spot.foot_m.y > kSnowLine_m,
                  [&](const GroundPoint& p) { return soil_.granite(p); });
}

void Forest::buildings(Canvas& canvas) const {
    draw_hamlet(canvas, hamlet_);
    draw_river_bridge(canvas, river_, kBridge, 2.6);
    draw_lookout(canvas, hamlet_.center_m + Vec2(70.0, -30.0), 24.0, 0.0);
}

/// Two trees at the edge of the green, a line between them, one voxel thick.
void Forest::slackline(Canvas& canvas, uint64_t key) const {
    const Vec2 from = hamlet_.center_m + Vec2(-12.0, 30.0);
    const Vec2 to = hamlet_.center_m + Vec2(12.0, 31.0);
    RandomStream random(key);
    for (const Vec2& at : {from, to}) {
        Spot spot{{at.x, canvas.ground().height_m(at), at.y}, 0.0, RandomStream(random.next())};
        draw_broadleaf(canvas, plant_at(spot, palette::kBeech, palette::kBark, 14.0));
    }
    const auto knot = [&](const Vec2& at) {
        return Vec3(at.x, canvas.ground().height_m(at) + 1.6, at.y);
    };
    draw_line(canvas, knot(from), knot(to), 0.35, {Rgb(0.55f, 0.10f, 0.06f), 0.05});
}

}  // namespace

Landscape make_forest(uint64_t seed) {
    const auto world = std::make_shared<const Forest>(seed);
    Landscape landscape;
    landscape.height_m = [world](const Vec2& at) { return world->height_m(at); };
    landscape.color = [world](const GroundPoint& p) { return world->color(p); };
    landscape.scatters = {
        {4.06, 4.0, [world](Spot& s, Canvas& c) { world->trees(s, c); }},
        {2.4, 0.5, [world](Spot& s, Canvas& c) { world->undergrowth(s, c); }},
        {0.9, 0.25, [world](Spot& s, Canvas& c) { world->meadow(s, c); }},
        {8.0, 0.8, [world](Spot& s, Canvas& c) { world->boulders(s, c); }},
        {17.0, 2.0, [world](Spot& s, Canvas& c) { world->tors(s, c); }},
    };
    landscape.structures = {
        [world](Canvas& c) { world->buildings(c); },
        [world, seed](Canvas& c) {
            world->slackline(c, random_key({seed, 26}));
        },
    };
    return landscape;
}

}  // namespace probebake::worldgen
