// TriangleMesh: the surfaces of a scene as importers of meshes deliver them and voxelisation takes
// them.
//
// Positions in metres, right-handed, +Y up, with every transform of the file applied. Triangles
// turn counter-clockwise seen from the front. Colours are linear Rec.709, emission is radiance in
// W·m⁻²·sr⁻¹; texels are as the file has them (sRGB, alpha linear).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "math/vec.h"

namespace probebake {

enum class TextureWrap : uint8_t { kRepeat, kClamp, kMirror };

struct Texture {
    int width_px = 0;
    int height_px = 0;
    std::vector<std::array<uint8_t, 4>> texels;  // sRGB and alpha, row by row from the top
    TextureWrap wrap_u = TextureWrap::kRepeat;
    TextureWrap wrap_v = TextureWrap::kRepeat;
};

/// What a point of a surface looks like: factor times texture times colour of the vertices.
struct MeshMaterial {
    std::string name;
    Rgb base_color{1.0f};
    float alpha = 1.0f;
    std::optional<uint32_t> base_color_texture;
    Rgb emission{0.0f};
    std::optional<uint32_t> emission_texture;
    /// Points of less alpha are holes; none where it is 0.
    float alpha_cutoff = 0.0f;
    bool double_sided = true;
};

struct MeshTriangle {
    std::array<uint32_t, 3> vertices{};
    uint32_t material = 0;
};

/// The sun of a file: direction of its light, and irradiance on a surface that faces it (W·m⁻²).
struct MeshSun {
    Vec3 direction{0.0, -1.0, 0.0};  // unit
    Rgb irradiance{0.0f};
};

struct TriangleMesh {
    std::vector<Vec3> positions;
    // Of as many entries as positions, or empty where nothing has any.
    std::vector<Vec2> texture_coordinates;     // (0, 0) at the top left of the picture
    std::vector<std::array<float, 4>> colors;  // linear, with alpha
    std::vector<MeshTriangle> triangles;       // every index is in range
    std::vector<MeshMaterial> materials;
    std::vector<Texture> textures;
    std::vector<MeshSun> suns;
    std::vector<std::string> warnings;  // what the importer left out or replaced
};

}  // namespace probebake
