// What a mesh became: the record that a scene of a mesh, its cache and its report keep.
#pragma once

#include <optional>
#include <vector>

#include "io/json.h"
#include "mesh/voxelise.h"

namespace probebake {

struct MeshWorld {
    VoxeliseReport voxels;
    uint64_t materials = 0;
    uint64_t textures = 0;
    std::vector<MeshSun> suns;  // of the file; a lighting state may take one
};

Json write_mesh_world(const MeshWorld& world);
/// Of what write_mesh_world wrote.
MeshWorld read_mesh_world(const Json& json);

}  // namespace probebake
