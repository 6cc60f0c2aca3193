#include "scene/generators/landscape.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace probebake::worldgen {
namespace {

constexpr int kTileSide = 64;

/// The columns [x0, x1) × [z0, z1).
struct Tile {
    int x0, z0, x1, z1;
};

void draw_ground(const Landscape& landscape, const Tile& tile, Canvas& canvas) {
    const Ground& ground = canvas.ground();
    for (int z = tile.z0; z < tile.z1; ++z) {
        for (int x = tile.x0; x < tile.x1; ++x) {
            const int top = ground.top(x, z);
            GroundPoint point{};
            point.slope = ground.slope(x, z);
            point.relief_m = ground.relief_m(x, z);
            for (int y = ground.bottom(x, z); y <= top; ++y) {
                const IVec3 voxel(x, y, z);
                point.at_m = canvas.center_m(voxel);
                point.depth_m = (top - y) * canvas.voxel_m();
                point.hash = canvas.hash(voxel);
                canvas.put_ground(voxel, landscape.color(point));
            }
        }
    }
}

/// Draws the objects of one grid whose feet stand in the tile.
void draw_scatter(const Scatter& scatter, uint64_t key, const Tile& tile, Canvas& canvas) {
    if (!canvas.resolves(scatter.detail_m)) return;
    const double voxel_m = canvas.voxel_m();
    const auto cell_of = [&](int column) {
        return static_cast<int>(std::floor(column * voxel_m / scatter.spacing_m));
    };
    for (int cz = cell_of(tile.z0); cz <= cell_of(tile.z1); ++cz) {
        for (int cx = cell_of(tile.x0); cx <= cell_of(tile.x1); ++cx) {
            RandomStream random(
                random_key({key, static_cast<uint64_t>(cx), static_cast<uint64_t>(cz)}));
            const double x_m = (cx + random.uniform()) * scatter.spacing_m;
            const double z_m = (cz + random.uniform()) * scatter.spacing_m;
            const int x = static_cast<int>(std::floor(x_m / voxel_m));
            const int z = static_cast<int>(std::floor(z_m / voxel_m));
            if (x < tile.x0 || x >= tile.x1 || z < tile.z0 || z >= tile.z1) continue;
            const Ground& ground = canvas.ground();
            Spot spot{{x_m, ground.height_m(Vec2(x_m, z_m)), z_m}, ground.slope(x, z), random};
            scatter.draw(spot, canvas);
        }
    }
}

std::vector<Voxel> concatenate(std::vector<std::vector<Voxel>> parts) {
    size_t total = 0;
    for (const auto& part : parts) total += part.size();
    std::vector<Voxel> all;
    all.reserve(total);
    for (auto& part : parts) {
        all.insert(all.end(), part.begin(), part.end());
        std::vector<Voxel>().swap(part);
    }
    return all;
}

}  // namespace

VoxelCloud voxelize(const Landscape& landscape, int size, uint64_t seed) {
    const double voxel_m = kWorldSide_m / size;
    const Ground ground(size, voxel_m, landscape.height_m);
    const uint64_t grain_key = random_key({seed, 1});
    const int tiles = std::max(1, size / kTileSide);
    const auto tile_count = static_cast<size_t>(tiles) * static_cast<size_t>(tiles);
    std::vector<std::vector<Voxel>> parts(tile_count + landscape.structures.size());
    tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) {
        Canvas canvas(size, voxel_m, &ground, grain_key);
        if (i < tile_count) {
            const int x = static_cast<int>(i) % tiles;
            const int z = static_cast<int>(i) / tiles;
            const Tile tile{x * size / tiles, z * size / tiles, (x + 1) * size / tiles,
                            (z + 1) * size / tiles};
            draw_ground(landscape, tile, canvas);
            for (size_t s = 0; s < landscape.scatters.size(); ++s) {
                draw_scatter(landscape.scatters[s], random_key({seed, 2, s}), tile, canvas);
            }
        } else {
            landscape.structures[i - tile_count](canvas);
        }
        parts[i] = canvas.take();
    });
    VoxelCloud cloud;
    cloud.voxels = concatenate(std::move(parts));
    cloud.depth = depth_for_extent(IVec3(size));
    return cloud;
}

}  // namespace probebake::worldgen
