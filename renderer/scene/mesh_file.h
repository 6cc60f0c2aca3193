// Meshes of scene files: glTF, OBJ and NFF, from the file's own units and axes to the world's.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "io/json.h"
#include "io/sha256.h"
#include "mesh/triangle_mesh.h"

namespace probebake {

enum class MeshFormat { kGltf, kObj, kNff };
/// "gltf", "obj", "nff"
std::string_view name_of(MeshFormat format);

/// The longest side of a mesh in voxels: of a world's 65,536 one begins half before it.
inline constexpr int kMaxMeshVoxels = 65534;

/// What a scene file says about its mesh; exactly one of the first two.
struct MeshFile {
    std::optional<double> voxel_size_m;
    std::optional<int> resolution;  // voxels along the longest side
    MeshFormat format = MeshFormat::kGltf;
    std::filesystem::path path;
    std::optional<std::string> materials;  // of OBJ: the MTL file to take, in the same folder
    bool z_up = false;                     // of OBJ and NFF
    bool two_sided = true;                 // of OBJ and NFF: all surfaces have two fronts
    bool solid = false;                    // what the surface closes in is filled
    double unit_m = 1.0;
    double emission_scale = 1.0;  // of glTF and OBJ: W·m⁻²·sr⁻¹ per unit of emission
};

/// The fields of a scene of that format. Problems go to the reader's issues.
MeshFile read_mesh_file(ObjectReader& scene, MeshFormat format,
                        const std::filesystem::path& folder);

/// Reads the mesh and all that it refers to, in metres and +Y up. Throws IoError.
TriangleMesh load_mesh(const MeshFile& file);

/// The size the scene file asks for. Throws IoError where the mesh would have more than
/// kMaxMeshVoxels along an axis.
double mesh_voxel_size_m(const MeshFile& file, const TriangleMesh& mesh);

/// Adds the mesh's file and all that it refers to, what is missing as missing. Throws IoError.
void hash_mesh(const MeshFile& file, Sha256& sha);

}  // namespace probebake
