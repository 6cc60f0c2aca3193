// What importers of meshes share: limits, textures, colours of materials.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>

#include "mesh/triangle_mesh.h"
#include "scene/folder_files.h"

namespace probebake {

/// More is an IoError before it is allocated.
struct MeshLimits {
    uint64_t max_triangles = uint64_t{1} << 25;
    uint64_t max_vertices = uint64_t{1} << 26;
    uint64_t max_texels = uint64_t{1} << 28;  // 1 GiB
};

/// Throws IoError, naming the file, where there are more.
void require_triangles(uint64_t count, const MeshLimits& limits, const std::string& file);
void require_vertices(uint64_t count, const MeshLimits& limits, const std::string& file);

/// Where emission or reflectance of a material may lie: throws IoError with `what` for values that
/// are negative or not finite; reflectances above 1 become 1, with a warning in the mesh.
Rgb checked_reflectance(const Vec3& color, const std::string& what, const std::string& file,
                        TriangleMesh& mesh);
Rgb checked_emission(const Vec3& color, const std::string& what, const std::string& file);

/// Appends, once.
void warn(TriangleMesh& mesh, const std::string& warning);

/// Puts pictures into the mesh's textures, each once. What is missing or neither PNG nor JPEG is a
/// warning in the mesh and no texture; what is damaged is an IoError.
class MeshTextures {
  public:
    /// All of them outlive it.
    MeshTextures(TriangleMesh& mesh, const ReadInner& read, const MeshLimits& limits,
                 std::string file)
        : mesh_(mesh), read_(read), limits_(limits), file_(std::move(file)) {}

    std::optional<uint32_t> from_file(const std::string& name, TextureWrap wrap_u,
                                      TextureWrap wrap_v);
    /// `name` says which it is ("model.glb: /images/3").
    std::optional<uint32_t> from_bytes(std::span<const std::byte> bytes, const std::string& name,
                                       TextureWrap wrap_u, TextureWrap wrap_v);

  private:
    using Key = std::tuple<std::string, TextureWrap, TextureWrap>;

    TriangleMesh& mesh_;
    const ReadInner& read_;
    const MeshLimits& limits_;
    std::string file_;
    uint64_t texels_ = 0;
    std::map<Key, std::optional<uint32_t>> known_;
};

}  // namespace probebake
