// Materials of a glTF model: colours, emission, textures, and where on them a vertex lies.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scene/gltf/tinygltf.h"
#include "scene/mesh_parts.h"

namespace probebake {

/// Which texture coordinates a material uses, and the map that is applied to them
/// (KHR_texture_transform): linear part by columns, then the offset.
struct GltfCoordinates {
    int set = 0;
    std::array<double, 6> map{1.0, 0.0, 0.0, 1.0, 0.0, 0.0};

    Vec2 mapped(const Vec2& uv) const {
        return {map[0] * uv.x + map[2] * uv.y + map[4], map[1] * uv.x + map[3] * uv.y + map[5]};
    }
    bool operator==(const GltfCoordinates&) const = default;
};

/// Of every material, in their order; adds them and their textures to the mesh, emission times
/// `emission_scale`. Pictures that no material shows are not looked at. Throws IoError.
std::vector<GltfCoordinates> add_materials(const tinygltf::Model& model, double emission_scale,
                                           MeshTextures& textures, const std::string& file,
                                           TriangleMesh& mesh);

}  // namespace probebake
