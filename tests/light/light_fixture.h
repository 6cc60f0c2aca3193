// Worlds to be lit, and what their faces show.
#pragma once

#include <gtest/gtest.h>

#include "light/lighting.h"
#include "support/random_cloud.h"

namespace probebake::test {

/// Fills [low, high) with voxels of one albedo.
inline void add_box(VoxelCloud& cloud, const IVec3& low, const IVec3& high,
                    const Rgb& albedo = Rgb(0.5f)) {
    for (int z = low.z; z < high.z; ++z) {
        for (int y = low.y; y < high.y; ++y) {
            for (int x = low.x; x < high.x; ++x) {
                cloud.voxels.push_back(make_voxel({x, y, z}, pack_rgb(albedo)));
            }
        }
    }
}

/// The six walls of a room, one voxel thick; low and high are its outer corners.
inline void add_room(VoxelCloud& cloud, const IVec3& low, const IVec3& high) {
    for (int axis = 0; axis < 3; ++axis) {
        IVec3 top = high;
        top[axis] = low[axis] + 1;
        add_box(cloud, low, top);
        IVec3 bottom = low;
        bottom[axis] = high[axis] - 1;
        add_box(cloud, bottom, high);
    }
}

/// Ground of one voxel at y = 0 over the whole world.
inline VoxelCloud flat_ground(int depth, const Rgb& albedo = Rgb(0.5f)) {
    VoxelCloud cloud;
    cloud.depth = depth;
    const int side = 1 << depth;
    add_box(cloud, {0, 0, 0}, {side, 1, side}, albedo);
    return cloud;
}

inline LitScene light(const VoxelTree& tree, const Lighting& lighting,
                      const LightingParams& params = {}) {
    const CancelToken cancel;
    return light_scene(tree, lighting, params, cancel);
}

/// Of a voxel's exposed face.
inline Rgb radiance_of(const VoxelTree& tree, const FaceColors& colors, const IVec3& voxel,
                       CubeFace face) {
    const auto index = tree.find_voxel(voxel);
    EXPECT_TRUE(index.has_value());
    const int f = index_of(face);
    EXPECT_TRUE(colors.voxels.exposes(*index, f));
    return unpack_rgb(colors.voxels.values[colors.voxels.index_of(*index, f)]) * colors.scale;
}

}  // namespace probebake::test
