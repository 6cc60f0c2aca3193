// Small random worlds of several kinds for the tests of trees and traversals.
#pragma once

#include <string>
#include <vector>

#include "math/random.h"
#include "voxels/voxel_cloud.h"

namespace probebake::test {

struct NamedCloud {
    std::string name;
    VoxelCloud cloud;
};

inline PackedRgb random_color(RandomStream& random) {
    return pack_rgb(Rgb(static_cast<float>(random.uniform()), static_cast<float>(random.uniform()),
                        static_cast<float>(random.uniform())));
}

/// Every position of [0, side)³ with the given probability.
inline VoxelCloud random_cloud(int depth, double density, uint64_t seed) {
    RandomStream random(random_key({seed, static_cast<uint64_t>(depth)}));
    VoxelCloud cloud;
    cloud.depth = depth;
    const int side = 1 << depth;
    for (int z = 0; z < side; ++z) {
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                if (random.uniform() < density) {
                    cloud.voxels.push_back(make_voxel({x, y, z}, random_color(random)));
                }
            }
        }
    }
    return cloud;
}

/// Few voxels in a wide world: the corners of the world and a cluster at a random place.
inline VoxelCloud sparse_cloud(int depth, int count, uint64_t seed) {
    RandomStream random(random_key({seed, 77}));
    VoxelCloud cloud;
    cloud.depth = depth;
    const int last = (1 << depth) - 1;
    for (int corner = 0; corner < 8; ++corner) {
        cloud.voxels.push_back(
            make_voxel({(corner & 1) * last, ((corner >> 1) & 1) * last, (corner >> 2) * last}, 1));
    }
    for (int i = 0; i < count; ++i) {
        const auto coordinate = [&] { return static_cast<int>(random.below(1u << depth)); };
        const int x = coordinate();
        const int y = coordinate();
        cloud.voxels.push_back(make_voxel({x, y, coordinate()}, random_color(random)));
    }
    return cloud;
}

inline std::vector<NamedCloud> named_clouds() {
    std::vector<NamedCloud> clouds;
    clouds.push_back({"empty", VoxelCloud{}});
    clouds.push_back({"single voxel", VoxelCloud{.voxels = {make_voxel({1, 2, 3}, 9)}}});
    clouds.push_back({"full, depth 2", random_cloud(2, 2.0, 1)});
    clouds.push_back({"dense, depth 3", random_cloud(3, 0.5, 2)});
    clouds.push_back({"sparse, depth 3", random_cloud(3, 0.03, 3)});
    clouds.push_back({"sparse, depth 4", random_cloud(4, 0.02, 4)});
    clouds.push_back({"dense, depth 4", random_cloud(4, 0.3, 5)});
    clouds.push_back({"very sparse, depth 5", random_cloud(5, 0.002, 6)});
    clouds.push_back({"wide, depth 9", sparse_cloud(9, 300, 7)});
    clouds.push_back({"widest, depth 16", sparse_cloud(16, 300, 8)});
    return clouds;
}

}  // namespace probebake::test
