// Wavefront OBJ with its MTL materials -> triangles.
//
// Faces of any number of corners, concave too; Kd (or 0.6 under a missing texture, 1 under one that
// is there), Ke, d and Tr, map_Kd, map_Ke. Materials of which d is less than 1, or which have a
// map_d, are holes where alpha is below 0.5: of map_d, alpha is taken where it is map_Kd's picture.
// Faces without a material are grey. Coordinates are the file's; normals, groups, lines, curves and
// colours of vertices are left out. tinyobjloader reads what obj_text.h has checked. Source: Alias
// Wavefront's Object Files, version 3.0; MTL as tinyobjloader has it (map_Ke is an extension).
#pragma once

#include <string>
#include <string_view>

#include "scene/mesh_parts.h"

namespace probebake {

inline constexpr Rgb kNoMaterialAlbedo{0.5f};

struct ObjParams {
    /// The MTL file to take instead of those that the file names.
    std::optional<std::string> materials;
    double emission_scale = 1.0;  // W·m⁻²·sr⁻¹ for 1 of Ke
    MeshLimits limits;
};

/// A missing MTL file or texture is a warning. Throws IoError, naming `file` or the MTL file, with
/// the line, for everything that is malformed or too large.
TriangleMesh import_obj(std::string_view text, const ObjParams& params, const ReadInner& read,
                        const std::string& file);

/// Names of the MTL files and textures that the import looks for; of the text itself, no more than
/// that is checked. Throws as import_obj.
std::vector<std::string> obj_references(std::string_view text, const ObjParams& params,
                                        const ReadInner& read, const std::string& file);

}  // namespace probebake
