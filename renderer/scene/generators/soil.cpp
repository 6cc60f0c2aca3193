#include "scene/generators/soil.h"

#include <cmath>

#include "scene/generators/palette.h"

namespace probebake::worldgen {
namespace {

Rgb shade(const Rgb& color, double factor) { return color * static_cast<float>(factor); }
double speckle(const GroundPoint& p, double spread) { return 1.0 + spread * (2.0 * p.hash - 1.0); }

}  // namespace

Soil::Soil(uint64_t seed)
    : patches_(random_key({seed, 101})),
      mottle_(random_key({seed, 102})),
      strata_(random_key({seed, 103})),
      stone_(random_key({seed, 104})) {}

Rgb Soil::granite(const GroundPoint& p) const {
    const Vec3& at = p.at_m;
    const Vec3 tilted(at.x / 14.0, (at.y + 0.33 * at.x - 0.21 * at.z) / 2.6, at.z / 14.0);
    const double band = strata_.at(tilted);
    const double blotch = stone_.fbm(at, {2.2, 2, 0.7});
    const double warmth = smooth_step(-0.1, 0.5, patches(p.plan()));
    Rgb color = mix(palette::kGraniteDark, palette::kGranite, 0.62 + 0.6 * band);
    color = mix(color, palette::kGraniteWarm, 0.75 * warmth);
    if (p.slope < 1.4 && blotch > 0.22) color = mix(color, palette::kLichen, 0.45);
    return shade(color, (1.0 + 0.55 * blotch) * speckle(p, 0.16));
}

Rgb Soil::sandstone(const GroundPoint& p) const {
    const Vec3& at = p.at_m;
    const double wobble = 2.0 * patches(p.plan()) + 0.5 * strata_.at(at / 3.0);
    const double level = (at.y + wobble) / 3.4;
    // Beds of irregular thickness and colour, each a different key into the same noise.
    const double bed = strata_.at(Vec2(level, 0.37));
    const double thin = strata_.at(Vec2(level * 4.3, 9.1));
    Rgb color =
        bed > 0.0
            ? mix(palette::kSandstoneOrange, palette::kSandstonePale, smooth_step(0.0, 0.55, bed))
            : mix(palette::kSandstoneOrange, palette::kSandstoneRed, smooth_step(0.0, -0.5, bed));
    color = shade(color, 1.0 + 0.28 * thin);
    if (p.slope > 0.9) {
        const double streak = stone_.at(Vec3(at.x / 1.3, at.y / 16.0, at.z / 1.3));
        color = mix(color, palette::kSandstoneDark, 0.7 * smooth_step(0.22, 0.6, streak));
    }
    return shade(color, speckle(p, 0.13));
}

Rgb Soil::sand(const GroundPoint& p) const {
    const double tone = mottle(p.plan());
    const Vec2 bent = p.plan() + 3.0 * Vec2(tone, patches(p.plan()));
    const double ripple = strata_.at(Vec2((0.8 * bent.x + 0.6 * bent.y) / 1.6, bent.y / 21.0));
    const Rgb color = mix(palette::kSand, palette::kSandLight, 0.5 + 0.6 * ripple);
    return shade(color, (1.0 + 0.12 * tone) * speckle(p, 0.07));
}

Rgb Soil::gravel(const GroundPoint& p) const {
    const double tone = mottle(p.plan());
    const double dust = smooth_step(-0.35, 0.45, patches(p.plan()) + 0.5 * tone);
    Rgb color = mix(palette::kGravel, palette::kSand, 0.25 + 0.6 * dust);
    color = mix(color, palette::kSandstoneOrange, 0.3 * smooth_step(0.0, 0.4, -tone));
    if (p.hash > 0.94) color = mix(color, palette::kSandstoneDark, 0.55);
    return shade(color, (1.0 + 0.18 * tone) * speckle(p, 0.17));
}

Rgb Soil::grass(const GroundPoint& p, double dryness) const {
    const double tone = mottle(p.plan());
    const double dry = dryness + 0.35 * patches(p.plan()) + 0.3 * tone - 0.05 * p.relief_m;
    Rgb color = mix(palette::kGrass, palette::kGrassAlpine, smooth_step(0.1, 0.6, dry));
    color = mix(color, palette::kGrassDry, smooth_step(0.5, 1.1, dry));
    if (p.hash > 0.93) color = mix(color, palette::kEarth, 0.5);
    return shade(color, (1.0 + 0.3 * tone) * speckle(p, 0.22));
}

Rgb Soil::forest_floor(const GroundPoint& p) const {
    const double tone = mottle(p.plan());
    Rgb color = mix(palette::kForestFloor, palette::kEarth, 0.5 + 0.9 * tone);
    const double moss = tone + 0.7 * patches(p.plan()) + 0.5 * (p.hash - 0.5);
    color = mix(color, palette::kMoss, 0.8 * smooth_step(0.0, 0.4, moss));
    if (p.hash > 0.95) color = mix(color, palette::kGrassDry, 0.5);
    return shade(color, speckle(p, 0.25));
}

Rgb Soil::path(const GroundPoint& p) const {
    const double tone = mottle(p.plan());
    return shade(mix(palette::kPath, palette::kEarth, 0.3 + 0.5 * tone), speckle(p, 0.2));
}

Rgb Soil::snow(const GroundPoint& p) const {
    const double drift = mottle(p.plan()) - 0.15 * p.relief_m;
    const Rgb color = mix(palette::kSnow, palette::kSnowShade, smooth_step(-0.1, 0.7, drift));
    return shade(color, speckle(p, 0.03));
}

Rgb Soil::water(const GroundPoint& p, double depth_m) const {
    Rgb color = mix(palette::kShallows, palette::kWater, smooth_step(0.0, 1.6, depth_m));
    const double ripple = stone_.fbm(p.plan(), {3.0, 2});
    return shade(color, (1.0 + 0.3 * ripple) * speckle(p, 0.08));
}

Rgb Soil::ice(const GroundPoint& p) const {
    const double crack = std::abs(stone_.fbm(p.plan(), {24.0, 3}));
    const double drift = mottle(p.plan()) + 0.6 * patches(p.plan());
    Rgb color = mix(palette::kIce, palette::kSnowShade, smooth_step(0.0, 0.5, drift));
    color = mix(palette::kSnow, color, smooth_step(0.0, 0.03, crack));
    return shade(color, speckle(p, 0.04));
}

bool snow_lies(const GroundPoint& p, double line_m, double mottle) {
    const double height = p.at_m.y - line_m + 14.0 * mottle - 4.0 * p.relief_m;
    const double held = 1.15 + 0.35 * mottle - 0.12 * p.relief_m;  // steepest slope that holds it
    if (p.depth_m > 0.8) return false;
    return height + 9.0 * (p.hash - 0.5) > 0.0 && p.slope + 0.25 * (p.hash - 0.5) < held;
}

}  // namespace probebake::worldgen
