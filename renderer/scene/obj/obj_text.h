// Wavefront OBJ and MTL as text: checked line by line, before tinyobjloader reads them.
//
// tinyobjloader reads what is no number as 0, passes indices of nothing on and overflows on long
// exponents. What these functions return holds nothing but statements that the importer needs, one
// per line, with numbers it reads as they are meant; what is malformed is an IoError with its line.
// Statements: v, vt, f, usemtl and mtllib of OBJ; newmtl, Kd, Ke, d, Tr, map_Kd, map_Ke and map_d
// of MTL. All others are passed over.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scene/mesh_parts.h"

namespace probebake {

struct ObjText {
    std::string text;  // v, vt, f, usemtl
    std::vector<std::string> material_files;
    uint64_t vertices = 0;
    uint64_t texture_coordinates = 0;
    uint64_t triangles = 0;
    bool has_colors = false;  // numbers behind the coordinates of a vertex
    bool has_others = false;  // lines, points, curves or surfaces
};

/// Every index is in range, no face has fewer than three corners. Throws IoError.
ObjText check_obj(std::string_view text, const MeshLimits& limits, const std::string& file);

/// The lines of mtllib, and nothing else looked at.
std::vector<std::string> material_files_of(std::string_view text, const std::string& file);

struct MtlText {
    std::string text;
    /// Of materials that say so themselves.
    std::set<std::string> with_kd;
    std::vector<std::string> textures;
    bool has_options = false;  // of textures, other than -clamp
};

/// Names of textures have '/' between their parts. Throws IoError.
MtlText check_mtl(std::string_view text, const std::string& file);

}  // namespace probebake
