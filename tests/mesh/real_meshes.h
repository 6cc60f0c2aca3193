// The real meshes of shared/data, as scenes have them.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "scene/mesh_file.h"
#include "support/data.h"

namespace probebake::test {

struct RealMesh {
    const char* name;
    MeshFormat format;
    const char* file;
    const char* materials;  // of OBJ
};

inline constexpr std::array<RealMesh, 3> kRealMeshes = {
    {{"ship", MeshFormat::kGltf, "mesh/dutch_ship_medium/dutch_ship_medium_1k.gltf", nullptr},
     {"living room", MeshFormat::kGltf, "mesh/living_room/living_room.glb", nullptr},
     {"pandora", MeshFormat::kObj, "mesh/pandora/pandora.obj", "pandora_kd.mtl"}}};

/// How to read one at so many voxels along its longest side; no value where it is absent.
inline std::optional<MeshFile> mesh_file_of(const RealMesh& mesh, int resolution) {
    const auto path = data_file(mesh.file);
    if (!path) return std::nullopt;
    MeshFile file{.resolution = resolution, .format = mesh.format, .path = *path};
    if (mesh.materials != nullptr) file.materials = mesh.materials;
    return file;
}

}  // namespace probebake::test
