#include "scene/generators/studies.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/generators/canvas.h"
#include "scene/generators/noise.h"
#include "scene/generators/palette.h"
#include "scene/generators/random.h"
#include "scene/generators/structures.h"
#include "scene/generators/trees.h"

namespace probebake::worldgen {
namespace {

Canvas study_canvas(int size, uint64_t seed) {
    return {size, kStudyVoxel_m, nullptr, random_key({seed, 61})};
}

int ground_y(int size) { return size / 8 - 1; }

Paint solid(const Rgb& color, double grain = 0.1) { return {color, grain}; }

/// Level ground, mottled, with a faint chequer of 16 voxels.
void draw_ground(Canvas& canvas, uint64_t seed) {
    const Noise noise(random_key({seed, 62}));
    const int y = ground_y(canvas.size());
    for (int z = 0; z < canvas.size(); ++z) {
        for (int x = 0; x < canvas.size(); ++x) {
            const double mottle = noise.fbm(Vec2(x, z), {40.0, 4, 0.6});
            const Rgb color = mix(palette::kGravel, palette::kGrassAlpine, 0.5 + 0.9 * mottle);
            const float tone = (x / 16 + z / 16) % 2 == 0 ? 1.12f : 0.88f;
            canvas.put({x, y, z}, {color * tone, 0.12, Layer::kGround});
        }
    }
}

enum class Bars { kAlongX, kAlongZ, kDiagonal, kCrossed };

bool on_bar(Bars bars, int u, int v, int period) {
    switch (bars) {
        case Bars::kAlongX:
            return v % period == 0;
        case Bars::kAlongZ:
            return u % period == 0;
        case Bars::kDiagonal:
            return (u + v) % period == 0;
        case Bars::kCrossed:
            break;
    }
    return u % period == 0 || v % period == 0;
}

/// A ball's shell, between radius − 1 and radius voxels.
void draw_ball(Canvas& canvas, const Vec3& center, double radius, const Paint& paint) {
    const IVec3 lo = IVec3(glm::floor(center - radius));
    const IVec3 hi = IVec3(glm::floor(center + radius));
    for (int z = lo.z; z <= hi.z; ++z) {
        for (int y = lo.y; y <= hi.y; ++y) {
            for (int x = lo.x; x <= hi.x; ++x) {
                const Vec3 d = Vec3(x, y, z) + 0.5 - center;
                const double r2 = glm::dot(d, d);
                const double inner = std::max(0.0, radius - 1.8);
                if (r2 <= radius * radius && r2 >= inner * inner) canvas.put({x, y, z}, paint);
            }
        }
    }
}

}  // namespace

VoxelCloud make_grating(int size, uint64_t seed) {
    Canvas canvas = study_canvas(size, seed);
    draw_ground(canvas, seed);
    constexpr std::array<int, 4> kPeriods = {2, 3, 4, 8};
    constexpr std::array<Bars, 4> kRows = {Bars::kAlongX, Bars::kAlongZ, Bars::kDiagonal,
                                           Bars::kCrossed};
    constexpr std::array<Rgb, 4> kColors = {Rgb(0.62f, 0.58f, 0.5f), Rgb(0.45f, 0.16f, 0.09f),
                                            Rgb(0.12f, 0.2f, 0.36f), Rgb(0.5f, 0.37f, 0.09f)};
    const int tile = size / 4;
    const int inset = tile / 8;
    const int extent = tile - 2 * inset;
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
            const auto r = static_cast<size_t>(row);
            const int period = kPeriods[static_cast<size_t>(column)];
            const Paint paint = solid(kColors[r], 0.05);
            const IVec3 corner(column * tile + inset, ground_y(size) + 1 + (row + 1) * tile / 8,
                               row * tile + inset);
            for (int v = 0; v < extent; ++v) {
                for (int u = 0; u < extent; ++u) {
                    if (!on_bar(kRows[r], u, v, period)) continue;
                    if (v < extent / 2) canvas.put(corner + IVec3(u, 0, v), paint);
                    // Upright, behind the lying half.
                    canvas.put({corner.x + u, ground_y(size) + 1 + v, corner.z + 3 * extent / 4},
                               paint);
                }
            }
        }
    }
    return canvas.take_cloud();
}

VoxelCloud make_net(int size, uint64_t seed) {
    Canvas canvas = study_canvas(size, seed);
    draw_ground(canvas, seed);
    const int base = ground_y(size) + 1;
    const int span = size / 4;  // between posts
    const int rope = std::max(4, size / 64);
    const double hung = base + size / 6.0;
    const double sag = size / 16.0;
    const Paint fiber = solid({0.5f, 0.42f, 0.28f}, 0.15);
    const auto height = [&](int x, int z) {
        const double tx = static_cast<double>(x % span) / span;
        const double tz = static_cast<double>(z % span) / span;
        const double dip = 4.0 * tx * (1.0 - tx) + 4.0 * tz * (1.0 - tz);
        return static_cast<int>(std::floor(hung - 0.5 * sag * dip));
    };
    for (int z = 0; z < size; ++z) {
        for (int x = 0; x < size; ++x) {
            if (x % rope != 0 && z % rope != 0) continue;
            // Filled down to the next voxel of the rope, so that it is one piece.
            int low = height(x, z);
            if (z % rope == 0 && x + 1 < size) low = std::min(low, height(x + 1, z) + 1);
            if (x % rope == 0 && z + 1 < size) low = std::min(low, height(x, z + 1) + 1);
            for (int y = std::min(low, height(x, z)); y <= height(x, z); ++y) {
                canvas.put({x, y, z}, fiber);
            }
            if (x % span == 0 && z % span == 0) {
                for (int y = base; y < height(x, z); ++y) {
                    canvas.put({x, y, z}, solid(palette::kTimberDark));
                }
            }
        }
    }
    RandomStream random(random_key({seed, 63}));
    for (int i = 0; i < 24; ++i) {
        const double radius = size * between(random, 0.012, 0.035);
        const double margin = 2.0 * radius;
        const double x = between(random, margin, size - margin);
        const double z = between(random, margin, size - margin);
        const Rgb color{static_cast<float>(between(random, 0.08, 0.6)),
                        static_cast<float>(between(random, 0.08, 0.5)),
                        static_cast<float>(between(random, 0.06, 0.4))};
        if (i % 2 == 0) {
            draw_ball(canvas, {x, base + radius, z}, radius, solid(color));
        } else {
            const Vec3 center = Vec3(x, base, z) * kStudyVoxel_m;
            const Vec3 half = Vec3(radius, 0.0, 0.7 * radius) * kStudyVoxel_m;
            canvas.box(center - half, center + half + Vec3(0.0, 1.5 * radius * kStudyVoxel_m, 0.0),
                       solid(color));
        }
    }
    return canvas.take_cloud();
}

VoxelCloud make_canopy(int size, uint64_t seed) {
    Canvas canvas = study_canvas(size, seed);
    draw_ground(canvas, seed);
    const int base = ground_y(size) + 1;
    constexpr std::array<Rgb, 3> kLeaves = {palette::kMaple, palette::kBirchLeaf, palette::kBeech};
    for (int layer = 0; layer < 3; ++layer) {
        const auto l = static_cast<size_t>(layer);
        const Noise noise(random_key({seed, 64, l}));
        const double middle = base + size * (0.10 + 0.06 * layer);
        for (int z = 0; z < size; ++z) {
            for (int x = 0; x < size; ++x) {
                const double cover = noise.fbm(Vec2(x, z), {size / 8.0, 3});
                const int y = static_cast<int>(middle + 0.015 * size * noise.at(Vec2(x, z) / 9.0));
                // Half of the ground shows through each layer.
                if (canvas.hash({x, y, z}) > 0.5 + 0.9 * cover) continue;
                canvas.put({x, y, z}, {kLeaves[l], 0.3, Layer::kLeaf});
            }
        }
    }
    const int spacing = size / 8;
    RandomStream random(random_key({seed, 65}));
    for (int z = 0; z < 8; ++z) {
        for (int x = 0; x < 8; ++x) {
            const double fx = (x + between(random, 0.2, 0.8)) * spacing;
            const double fz = (z + between(random, 0.2, 0.8)) * spacing;
            const Vec3 foot = Vec3(fx, base, fz) * kStudyVoxel_m;
            const double tall = 0.2 * size * kStudyVoxel_m;
            canvas.limb(foot, foot + Vec3(0.0, tall, 0.0),
                        Vec2(0.006, 0.003) * (size * kStudyVoxel_m),
                        {palette::kBark, 0.2, Layer::kWood});
        }
    }
    return canvas.take_cloud();
}

VoxelCloud make_slackline(int size, uint64_t seed) {
    Canvas canvas = study_canvas(size, seed);
    draw_ground(canvas, seed);
    const double side_m = size * kStudyVoxel_m;
    const double base_m = (ground_y(size) + 1) * kStudyVoxel_m;
    RandomStream random(random_key({seed, 66}));
    const auto at = [&](double x, double z) { return Vec3(x * side_m, base_m, z * side_m); };
    const Vec3 west = at(0.28, 0.5);
    const Vec3 east = at(0.72, 0.52);
    for (const Vec3& foot : {west, east}) {
        Plant tree;
        tree.foot_m = foot;
        tree.height_m = std::min(14.0, 0.4 * side_m);
        tree.random = RandomStream(random.next());
        tree.leaf = palette::kBeech;
        tree.bark = palette::kBark;
        draw_broadleaf(canvas, tree);
    }
    const Vec3 up(0.0, 0.06 * side_m, 0.0);
    draw_line(canvas, west + up, east + up, 0.012 * side_m, solid({0.55f, 0.1f, 0.06f}, 0.0));
    // Wires at three heights from pole to pole, across the line.
    const Vec3 north = at(0.45, 0.1);
    const Vec3 south = at(0.6, 0.9);
    for (const Vec3& foot : {north, south}) {
        canvas.limb(foot, foot + Vec3(0.0, 0.3 * side_m, 0.0), {0.15, 0.12},
                    solid(palette::kTimberDark));
    }
    for (const double height : {0.22, 0.255, 0.29}) {
        const Vec3 hook(0.0, height * side_m, 0.0);
        draw_line(canvas, north + hook, south + hook, 0.03 * side_m, solid(palette::kSlate, 0.0));
    }
    return canvas.take_cloud();
}

VoxelCloud make_torch(int size, uint64_t seed) {
    Canvas canvas = study_canvas(size, seed);
    draw_ground(canvas, seed);
    const int base = ground_y(size) + 1;
    const int wall_z = size / 2;
    for (int y = base; y < base + size / 2; ++y) {
        for (int x = size / 8; x < size - size / 8; ++x) {
            for (int z = wall_z; z < wall_z + 2; ++z) {
                const IVec3 block((x + (y / 3) % 2 * 3) / 6, y / 3, z);
                const auto tone = static_cast<float>(0.8 + 0.4 * canvas.hash(block));
                canvas.put({x, y, z}, solid(palette::kMasonry * tone));
            }
        }
    }
    const IVec3 flame(size / 2, base + size / 4, wall_z - 2);
    canvas.put(flame + IVec3(0, -1, 0), solid(palette::kTimberDark));
    canvas.put(flame + IVec3(0, -2, 1), solid(palette::kTimberDark));
    canvas.put(flame, {Rgb(0.6f, 0.35f, 0.15f), 0.0, Layer::kLight, kTorchRadiance});
    return canvas.take_cloud();
}

}  // namespace probebake::worldgen
