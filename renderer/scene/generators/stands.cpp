#include "scene/generators/stands.h"

#include <array>

#include "scene/generators/noise.h"
#include "scene/generators/palette.h"
#include "scene/generators/random.h"

namespace probebake::worldgen {

Plant plant_at(Spot& spot, const Rgb& leaf, const Rgb& bark, double height_m, double foliage) {
    Plant plant;
    plant.foot_m = spot.foot_m;
    plant.height_m = height_m;
    plant.density = foliage;
    // Brightness and warmth vary from plant to plant, greens between bluish and yellowish.
    const double brightness = between(spot.random, 0.72, 1.3);
    const double warmth = between(spot.random, -0.22, 0.22);
    plant.leaf =
        leaf * Rgb(static_cast<float>(brightness * (1.0 + warmth)), static_cast<float>(brightness),
                   static_cast<float>(brightness * (1.0 - warmth)));
    plant.bark = bark * static_cast<float>(between(spot.random, 0.8, 1.2));
    plant.random = RandomStream(spot.random.next());
    return plant;
}

void plant_tree(Canvas& canvas, Spot& spot, const Stand& stand) {
    RandomStream& random = spot.random;
    const double choice = random.uniform();
    // Many young trees, few old ones.
    const double youth = between(random, 0.45, 1.0);
    const double age = youth * between(random, 0.75, 1.0);
    const double tall = stand.stature * age;
    const bool turned = random.uniform() < stand.autumn;
    if (choice < stand.dead) {
        draw_dead_tree(canvas, plant_at(spot, palette::kDeadWood, palette::kDeadWood, 13.0 * tall));
    } else if (choice < stand.dead + stand.conifers) {
        if (random.uniform() < 0.22) {
            Plant pine =
                plant_at(spot, palette::kPine, palette::kBarkPine, 21.0 * tall, stand.foliage);
            pine.snow = stand.snow;
            draw_pine(canvas, pine);
        } else {
            const Rgb needles = turned ? palette::kLarch : palette::kSpruce;
            Plant spruce = plant_at(spot, needles, palette::kBark, 24.0 * tall, stand.foliage);
            spruce.snow = stand.snow;
            draw_spruce(canvas, spruce);
        }
    } else if (choice < stand.dead + stand.conifers + stand.birches) {
        const Rgb leaf = turned ? palette::kLarch : palette::kBirchLeaf;
        Plant birch = plant_at(spot, leaf, palette::kBirchBark, 16.0 * tall, stand.foliage);
        birch.snow = stand.snow;
        draw_birch(canvas, birch);
    } else {
        constexpr std::array<Rgb, 3> kTurned = {palette::kMaple, palette::kLarch,
                                                Rgb(0.31f, 0.19f, 0.035f)};
        const Rgb leaf = turned ? kTurned[random.below(kTurned.size())] : palette::kBeech;
        Plant tree = plant_at(spot, leaf, palette::kBark, 18.0 * tall, stand.foliage);
        tree.snow = stand.snow;
        draw_broadleaf(canvas, tree);
    }
}

void plant_undergrowth(Canvas& canvas, Spot& spot, double snow) {
    RandomStream& random = spot.random;
    const double choice = random.uniform();
    if (choice < 0.04) {
        draw_log(canvas, plant_at(spot, palette::kMoss, palette::kBark, between(random, 3.0, 8.0)));
    } else if (choice < 0.07) {
        draw_stump(canvas, plant_at(spot, palette::kMoss, palette::kTimber, 1.0));
    } else {
        const Rgb leaf = choice < 0.5 ? palette::kMoss * 1.2f : palette::kBeech;
        Plant bush = plant_at(spot, leaf, palette::kBark, between(random, 0.5, 1.9));
        bush.snow = snow;
        draw_bush(canvas, bush);
    }
}

void plant_meadow(Canvas& canvas, Spot& spot, double dryness, double height_m) {
    constexpr std::array<Rgb, 4> kFlowers = {Rgb(0.62f, 0.60f, 0.52f), Rgb(0.60f, 0.44f, 0.05f),
                                             Rgb(0.24f, 0.14f, 0.42f), Rgb(0.50f, 0.11f, 0.10f)};
    RandomStream& random = spot.random;
    const double flower = random.uniform();
    const Rgb blade = flower < 0.06 ? kFlowers[random.below(kFlowers.size())]
                                    : mix(palette::kGrass * 1.15f, palette::kGrassDry, dryness);
    draw_tuft(canvas, plant_at(spot, blade, palette::kBark, flower < 0.06 ? 0.25 : height_m), 0.6);
}

void plant_desert_shrub(Canvas& canvas, Spot& spot) {
    RandomStream& random = spot.random;
    const double choice = random.uniform();
    if (choice < 0.012) {
        draw_cactus(canvas,
                    plant_at(spot, palette::kCactus, palette::kBark, between(random, 2.0, 5.0)));
    } else if (choice < 0.8) {
        const double tall = between(random, 0.6, 1.9);
        draw_dry_shrub(canvas, plant_at(spot, palette::kSage, palette::kDeadWood, tall));
    } else {
        const double tall = between(random, 0.5, 1.6);
        draw_bush(canvas, plant_at(spot, palette::kSage, palette::kDeadWood, tall, 0.6));
    }
}

}  // namespace probebake::worldgen
