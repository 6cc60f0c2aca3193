#include "scene/generators/rocks.h"

#include <cmath>

#include "scene/generators/palette.h"
#include "scene/generators/random.h"

namespace probebake::worldgen {

void draw_rock(Canvas& canvas, const Rock& rock, const RockColor& color) {
    const Noise noise(rock.key);
    const double reach = 1.0 + rock.roughness;
    const IVec3 lo = canvas.voxel_at(rock.center_m - rock.radii_m * reach) - 1;
    const IVec3 hi = canvas.voxel_at(rock.center_m + rock.radii_m * reach) + 1;
    const IVec3 extent = hi - lo + 1;
    const auto index = [&](int x, int y, int z) {
        const auto row =
            static_cast<size_t>(z) * static_cast<size_t>(extent.y) + static_cast<size_t>(y);
        return row * static_cast<size_t>(extent.x) + static_cast<size_t>(x);
    };
    // Octaves finer than a voxel would be lost.
    const double voxels = rock.radii_m.x / canvas.voxel_m();
    const int octaves = voxels < 3.0 ? 1 : voxels < 8.0 ? 2 : 3;
    const double largest = std::max({rock.radii_m.x, rock.radii_m.y, rock.radii_m.z});
    std::vector<uint8_t> solid(index(0, 0, extent.z), 0);
    for (int z = 0; z < extent.z; ++z) {
        for (int y = 0; y < extent.y; ++y) {
            for (int x = 0; x < extent.x; ++x) {
                const Vec3 d = canvas.center_m(lo + IVec3(x, y, z)) - rock.center_m;
                const Vec3 unit = d / rock.radii_m;
                const double r = std::sqrt(glm::dot(unit, unit));
                if (r > reach) continue;
                // Boxy facets: the surface follows the largest component as well as the radius.
                const Vec3 a = glm::abs(unit);
                const double boxy = 0.45 * r + 0.62 * std::max({a.x, a.y, a.z});
                const bool inside = r < 1.0 - 1.3 * rock.roughness;
                if (inside ||
                    boxy + rock.roughness * noise.fbm(d, {0.9 * largest, octaves, 0.55}) < 1.0) {
                    solid[index(x, y, z)] = 1;
                }
            }
        }
    }
    for (int z = 1; z + 1 < extent.z; ++z) {
        for (int y = 1; y + 1 < extent.y; ++y) {
            for (int x = 1; x + 1 < extent.x; ++x) {
                if (solid[index(x, y, z)] == 0) continue;
                const bool buried = solid[index(x - 1, y, z)] && solid[index(x + 1, y, z)] &&
                                    solid[index(x, y - 1, z)] && solid[index(x, y + 1, z)] &&
                                    solid[index(x, y, z - 1)] && solid[index(x, y, z + 1)];
                if (buried) continue;
                const IVec3 voxel = lo + IVec3(x, y, z);
                GroundPoint point{};
                point.at_m = canvas.center_m(voxel);
                point.slope = solid[index(x, y + 1, z)] ? 3.0 : 0.3;
                point.hash = canvas.hash(voxel);
                const bool snowy = rock.snowy && !solid[index(x, y + 1, z)] && point.hash < 0.85;
                canvas.put(voxel, {snowy ? palette::kSnow : color(point), 0.05, Layer::kRock});
            }
        }
    }
}

void draw_boulders(Canvas& canvas, Spot& spot, double radius_m, bool snowy,
                   const RockColor& color) {
    RandomStream& random = spot.random;
    const int count = 1 + static_cast<int>(random.below(4));
    double radius = radius_m;
    Vec3 at = spot.foot_m;
    for (int i = 0; i < count; ++i) {
        Rock rock;
        rock.radii_m = Vec3{radius * between(random, 0.8, 1.25), radius * between(random, 0.6, 1.0),
                            radius * between(random, 0.8, 1.25)};
        rock.center_m = {at.x, canvas.ground().height_m(Vec2(at.x, at.z)) + 0.25 * rock.radii_m.y,
                         at.z};
        rock.snowy = snowy;
        rock.key = random.next();
        draw_rock(canvas, rock, color);
        at = spot.foot_m + random_offset(random, 1.2 * radius_m, 2.6 * radius_m);
        radius = radius_m * between(random, 0.25, 0.6);
    }
}

}  // namespace probebake::worldgen
