// A small world to render: ground, pillars and a net of single voxels, in many colours.
#pragma once

#include "support/random_cloud.h"
#include "voxels/trace.h"

namespace probebake::test {

inline VoxelCloud small_world_voxels() {
    RandomStream random(1234);
    VoxelCloud cloud;
    cloud.depth = 6;
    for (int z = 0; z < 64; ++z) {
        for (int x = 0; x < 64; ++x) {
            const int height = 6 + (x * z) % 5;
            for (int y = height - 3; y < height; ++y) {
                cloud.voxels.push_back(make_voxel({x, y, z}, random_color(random)));
            }
            if ((x % 16 == 5 || x % 16 == 6) && z % 16 == 9) {
                for (int y = height; y < 40; ++y) {
                    cloud.voxels.push_back(make_voxel({x, y, z}, random_color(random)));
                }
            }
            if (x % 3 == 0 || z % 4 == 0) {
                cloud.voxels.push_back(make_voxel({x, 50, z}, random_color(random)));
            }
        }
    }
    return cloud;
}

inline VoxelTree small_world() { return VoxelTree::build(small_world_voxels()); }

/// In free air between the ground and the net.
inline const Vec3 kSmallWorldProbe{30.3, 30.6, 29.2};

}  // namespace probebake::test
