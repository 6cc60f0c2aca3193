#include "scene/generators/plants.h"

#include <algorithm>
#include <cmath>

#include "scene/generators/random.h"

namespace probebake::worldgen {
void draw_bush(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const double radius = 0.55 * plant.height_m;
    const int lobes = 3 + static_cast<int>(random.below(4));
    for (int i = 0; i < lobes; ++i) {
        const double lobe = radius * between(random, 0.45, 0.8);
        Vec3 at = plant.foot_m + random_offset(random, 0.0, radius);
        at.y += 0.6 * lobe + between(random, 0.0, 0.4 * radius);
        const double tint = between(random, 0.8, 1.25);
        canvas.foliage(at, Vec3(lobe, 0.8 * lobe, lobe), leaves_of(plant, 1.4, tint),
                       random.next());
    }
}

void draw_dry_shrub(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const int twigs = 5 + static_cast<int>(random.below(7));
    const Paint wood{plant.bark, 0.25, Layer::kWood};
    for (int i = 0; i < twigs; ++i) {
        Vec3 tip = plant.foot_m + random_azimuth(random) * (0.6 * plant.height_m);
        tip.y += plant.height_m * between(random, 0.4, 1.0);
        const double tint = between(random, 0.8, 1.25);
        canvas.limb(plant.foot_m, tip, {0.03, 0.02}, wood);
        const double radius = 0.22 * plant.height_m;
        canvas.foliage(tip, Vec3(radius, 0.8 * radius, radius), leaves_of(plant, 0.8, tint),
                       random.next());
    }
}

void draw_cactus(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const Paint flesh{plant.leaf, 0.18, Layer::kWood};
    const double height = plant.height_m;
    canvas.limb(plant.foot_m - kUp * 0.3, plant.foot_m + kUp * height, {0.3, 0.24}, flesh);
    const int arms = static_cast<int>(random.below(4));
    for (int i = 0; i < arms; ++i) {
        const Vec3 root = plant.foot_m + kUp * (height * between(random, 0.35, 0.6));
        const Vec3 elbow = root + random_offset(random, 0.8, 1.2) + kUp * 0.25;
        canvas.limb(root, elbow, {0.2, 0.2}, flesh);
        canvas.limb(elbow, elbow + kUp * (height * between(random, 0.2, 0.4)), {0.2, 0.16}, flesh);
    }
}

void draw_tuft(Canvas& canvas, Plant plant, double radius_m) {
    RandomStream& random = plant.random;
    const int blades = 2 + static_cast<int>(random.below(5));
    const Ground& ground = canvas.ground();
    for (int i = 0; i < blades; ++i) {
        const Vec3 away = random_offset(random, 0.0, radius_m);
        const Vec3 at = plant.foot_m + away;
        const IVec3 foot = canvas.voxel_at({at.x, 0.0, at.z});
        const double tall_m = plant.height_m * between(random, 0.3, 1.0);
        const int tall = std::max(1, static_cast<int>(std::lround(tall_m / canvas.voxel_m())));
        const int top = ground.top(foot.x, foot.z);
        const Paint paint{plant.leaf * static_cast<float>(between(random, 0.75, 1.3)), 0.15,
                          Layer::kLitter};
        for (int y = 1; y <= tall; ++y) canvas.put({foot.x, top + y, foot.z}, paint);
    }
}

void draw_log(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const Vec3 half = random_azimuth(random) * (0.5 * plant.height_m);
    const Paint wood{plant.bark, 0.25, Layer::kWood};
    const auto resting = [&](const Vec3& p) {
        return Vec3(p.x, canvas.ground().height_m(Vec2(p.x, p.z)) + 0.2, p.z);
    };
    canvas.limb(resting(plant.foot_m - half), resting(plant.foot_m + half), {0.28, 0.2}, wood);
}

void draw_stump(Canvas& canvas, Plant plant) {
    const Paint wood{plant.bark, 0.2, Layer::kWood};
    canvas.limb(plant.foot_m - kUp * 0.3, plant.foot_m + kUp * 0.5, {0.4, 0.32}, wood);
}

}  // namespace probebake::worldgen
