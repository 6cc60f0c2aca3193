#include "scene/generators/trees.h"

#include <algorithm>
#include <cmath>

#include "scene/generators/noise.h"
#include "scene/generators/random.h"

namespace probebake::worldgen {
namespace {

/// Turned by the golden angle: successive branches never stand above each other.
Vec3 next_azimuth(const Vec3& a) {
    constexpr double kCos = -0.7373688781;
    constexpr double kSin = 0.6754902943;
    return {kCos * a.x - kSin * a.z, 0.0, kSin * a.x + kCos * a.z};
}

Paint bark_paint(const Plant& plant) { return {plant.bark, 0.25, Layer::kWood}; }

/// A branch; where voxels are much wider than it, the leaves alone make the crown.
void draw_branch(Canvas& canvas, const Plant& plant, const Vec3& from_m, const Vec3& to_m,
                 const Vec2& radii_m) {
    if (canvas.resolves(8.0 * radii_m.x)) canvas.limb(from_m, to_m, radii_m, bark_paint(plant));
}

/// The trunk from below the ground to `height_m`, tapering.
Vec3 draw_trunk(Canvas& canvas, const Plant& plant, double height_m, const Vec2& radii_m,
                const Vec3& lean = Vec3(0.0)) {
    const Vec3 top = plant.foot_m + kUp * height_m + lean * height_m;
    // A voxel below the top, so that where voxels are large no bare wood sticks out of the crown.
    const Vec3 end = top - kUp * std::min(0.5 * height_m, canvas.voxel_m());
    canvas.limb(plant.foot_m - kUp * 0.6, end, radii_m, bark_paint(plant));
    return top;
}

}  // namespace

Foliage leaves_of(const Plant& plant, double density_per_m, double tint) {
    return {plant.leaf * static_cast<float>(tint), density_per_m * plant.density, plant.snow,
            Layer::kLeaf};
}

void draw_spruce(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const double height = plant.height_m;
    const double base = height * between(random, 0.04, 0.14);
    const double reach = height * between(random, 0.17, 0.23);
    draw_trunk(canvas, plant, height * 0.97, {0.012 * height + 0.06, 0.04});
    Vec3 azimuth = random_azimuth(random);
    const double step = std::max(0.16, 0.35 * canvas.voxel_m());
    for (double y = base; y < height; y += step * between(random, 0.7, 1.3)) {
        azimuth = next_azimuth(azimuth);
        const double t = (y - base) / (height - base);
        const double full = reach * (1.0 - t) * (1.0 + 0.45 * t);
        const double length = full * between(random, 0.72, 1.12) + 0.2;
        const double rise = mix(-0.38, 0.25, t);
        const Vec3 root = plant.foot_m + kUp * y;
        const double tint = between(random, 0.8, 1.25);
        if (length > 1.0) {
            const Vec3 tip = root + azimuth * (0.7 * length) + kUp * (0.7 * rise * length);
            draw_branch(canvas, plant, root, tip, {0.04, 0.02});
        }
        for (double s = 0.3; s <= length; s += 0.42) {
            const double along = s / length;
            const double half_width = 0.16 + 0.38 * (1.0 - along) * std::min(1.0, length / 1.6);
            // Branches hang towards the middle and turn up at the tip.
            const double sag = rise * s + 0.22 * length * along * along;
            canvas.foliage(root + azimuth * s + kUp * sag, Vec3(half_width, 0.2, half_width),
                           leaves_of(plant, 2.0, tint), random.next());
        }
    }
    canvas.foliage(plant.foot_m + kUp * height, Vec3(0.2, 0.5, 0.2), leaves_of(plant, 2.0, 1.2),
                   random.next());
}

void draw_pine(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const double height = plant.height_m;
    const Vec3 lean = random_offset(random, 0.0, 0.06);
    const Vec3 top = draw_trunk(canvas, plant, height * 0.93, {0.016 * height + 0.06, 0.07}, lean);
    Vec3 azimuth = random_azimuth(random);
    const int limbs = 9 + static_cast<int>(random.below(6));
    for (int i = 0; i < limbs; ++i) {
        azimuth = next_azimuth(azimuth);
        const double t = between(random, 0.52, 1.0);
        const Vec3 root = plant.foot_m + (top - plant.foot_m) * t;
        const double length = height * between(random, 0.12, 0.2) * (1.25 - 0.6 * t);
        const Vec3 tip = root + azimuth * length + kUp * (length * between(random, 0.05, 0.45));
        draw_branch(canvas, plant, root, tip, {0.09, 0.03});
        for (int tuft = 0; tuft < 4; ++tuft) {
            const double along = between(random, 0.55, 1.1);
            const Vec3 at = root + (tip - root) * along + random_offset(random, 0.0, 0.7);
            const double radius = between(random, 0.55, 1.0);
            const double tint = between(random, 0.8, 1.3);
            canvas.foliage(at + kUp * 0.2, Vec3(radius, 0.5 * radius, radius),
                           leaves_of(plant, 1.5, tint), random.next());
        }
    }
    canvas.foliage(top, Vec3(0.9, 0.7, 0.9), leaves_of(plant, 1.5, 1.15), random.next());
}

void draw_broadleaf(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const double height = plant.height_m;
    const double spread = height * between(random, 0.26, 0.36);
    const Vec3 lean = random_offset(random, 0.0, 0.08);
    const Vec3 fork = draw_trunk(canvas, plant, height * between(random, 0.28, 0.4),
                                 {0.022 * height + 0.08, 0.014 * height + 0.05}, lean);
    const Vec3 crown = plant.foot_m + kUp * (0.64 * height);
    Vec3 azimuth = random_azimuth(random);
    const int limbs = 6 + static_cast<int>(random.below(4));
    for (int i = 0; i < limbs; ++i) {
        azimuth = next_azimuth(azimuth);
        const double out = spread * between(random, 0.3, 0.85);
        const double level = between(random, -0.12, 0.26) * height;
        const Vec3 joint = crown + azimuth * out + kUp * level;
        draw_branch(canvas, plant, fork, joint, {0.008 * height + 0.04, 0.05});
        const int twigs = 4 + static_cast<int>(random.below(3));
        for (int k = 0; k < twigs; ++k) {
            Vec3 away = random_offset(random, 0.3, 1.0);
            away.y = between(random, -0.35, 0.75);
            const Vec3 tip = joint + away * (0.34 * spread);
            draw_branch(canvas, plant, joint, tip, {0.05, 0.02});
            const double radius = std::clamp(spread * between(random, 0.22, 0.36), 0.4, 1.5);
            const double tint = between(random, 0.75, 1.3);
            canvas.foliage(tip, Vec3(radius, 0.72 * radius, radius), leaves_of(plant, 1.05, tint),
                           random.next());
        }
    }
}

void draw_birch(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const double height = plant.height_m;
    const Vec3 lean = random_offset(random, 0.0, 0.1);
    const Vec3 top = draw_trunk(canvas, plant, height * 0.95, {0.009 * height + 0.04, 0.03}, lean);
    Vec3 azimuth = random_azimuth(random);
    const double step = std::max(0.3, 0.4 * canvas.voxel_m());
    for (double t = 0.32; t < 1.0; t += step / height) {
        azimuth = next_azimuth(azimuth);
        const Vec3 root = plant.foot_m + (top - plant.foot_m) * t;
        const double full = height * 0.17 * std::sqrt(std::max(0.0, 1.05 - t));
        const double length = full * between(random, 0.6, 1.2);
        const Vec3 tip = root + azimuth * length + kUp * (0.45 * length);
        const double radius = between(random, 0.35, 0.7);
        const double tint = between(random, 0.8, 1.25);
        canvas.foliage(tip, Vec3(radius, 0.9 * radius, radius), leaves_of(plant, 0.9, tint),
                       random.next());
        canvas.foliage(tip - kUp * (0.9 * radius), Vec3(0.6 * radius, radius, 0.6 * radius),
                       leaves_of(plant, 0.7, 0.95 * tint), random.next());
    }
}

void draw_dead_tree(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const double height = plant.height_m;
    const Vec3 lean = random_offset(random, 0.0, 0.15);
    const Vec3 top = draw_trunk(canvas, plant, height, {0.016 * height + 0.06, 0.05}, lean);
    Vec3 azimuth = random_azimuth(random);
    const int limbs = 5 + static_cast<int>(random.below(6));
    for (int i = 0; i < limbs; ++i) {
        azimuth = next_azimuth(azimuth);
        const Vec3 root = plant.foot_m + (top - plant.foot_m) * between(random, 0.35, 0.95);
        const double length = height * between(random, 0.08, 0.24);
        const Vec3 elbow = root + azimuth * length + kUp * (0.4 * length);
        draw_branch(canvas, plant, root, elbow, {0.07, 0.04});
        draw_branch(canvas, plant, elbow, elbow + (random_azimuth(random) + kUp) * (0.4 * length),
                    {0.04, 0.02});
    }
}

void draw_palm(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const double height = plant.height_m;
    const Vec3 lean = random_offset(random, 0.03, 0.28);
    // A trunk that rises steeper and steeper.
    Vec3 last = plant.foot_m - kUp * 0.5;
    constexpr int kPieces = 5;
    for (int i = 1; i <= kPieces; ++i) {
        const double t = static_cast<double>(i) / kPieces;
        const Vec3 next = plant.foot_m + kUp * (height * t) + lean * (height * t * (2.0 - t));
        canvas.limb(last, next, {0.2 - 0.08 * t, 0.19 - 0.08 * t}, bark_paint(plant));
        last = next;
    }
    Vec3 azimuth = random_azimuth(random);
    const int fronds = 12 + static_cast<int>(random.below(6));
    for (int i = 0; i < fronds; ++i) {
        azimuth = next_azimuth(azimuth);
        const double length = between(random, 2.2, 3.6);
        const double rise = between(random, 0.1, 1.1);
        const double tint = between(random, 0.75, 1.3);
        for (double s = 0.15; s <= length; s += 0.18) {
            const double along = s / length;
            const Vec3 at = last + azimuth * s + kUp * (rise * s - 0.36 * s * s);
            const double half_width = 0.4 * (1.0 - along) + 0.08;
            canvas.foliage(at, Vec3(half_width, 0.13, half_width), leaves_of(plant, 1.6, tint),
                           random.next());
        }
    }
}

void draw_acacia(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const double height = plant.height_m;
    const double spread = height * between(random, 0.5, 0.7);
    const Vec3 lean = random_offset(random, 0.0, 0.2);
    const Vec3 fork =
        draw_trunk(canvas, plant, height * between(random, 0.3, 0.45), {0.22, 0.15}, lean);
    Vec3 azimuth = random_azimuth(random);
    const int limbs = 6 + static_cast<int>(random.below(4));
    for (int i = 0; i < limbs; ++i) {
        azimuth = next_azimuth(azimuth);
        const double level = height * between(random, 0.84, 1.0);
        const double out = spread * between(random, 0.15, 0.85);
        const Vec3 tip = plant.foot_m + kUp * level + azimuth * out;
        draw_branch(canvas, plant, fork, tip, {0.11, 0.04});
        for (int k = 0; k < 3; ++k) {
            const double radius = between(random, 0.7, 1.3);
            const double tint = between(random, 0.8, 1.25);
            const Vec3 at = tip + random_offset(random, 0.0, 0.9);
            canvas.foliage(at, Vec3(radius, 0.38, radius), leaves_of(plant, 1.2, tint),
                           random.next());
        }
    }
}

void draw_cypress(Canvas& canvas, Plant plant) {
    RandomStream& random = plant.random;
    const double height = plant.height_m;
    draw_trunk(canvas, plant, height * 0.8, {0.18, 0.06});
    const double widest = height * between(random, 0.085, 0.12);
    Vec3 azimuth = random_azimuth(random);
    const double step = std::max(0.22, 0.4 * canvas.voxel_m());
    for (double y = 0.06 * height; y < height; y += step) {
        azimuth = next_azimuth(azimuth);
        const double t = y / height;
        const double radius = widest * std::min(1.0, 6.0 * t) * std::sqrt(std::max(0.0, 1.02 - t));
        const double tint = between(random, 0.75, 1.25);
        canvas.foliage(plant.foot_m + kUp * y + azimuth * (0.55 * radius),
                       Vec3(0.6 * radius + 0.15, 0.55, 0.6 * radius + 0.15),
                       leaves_of(plant, 1.5, tint), random.next());
    }
}

}  // namespace probebake::worldgen
