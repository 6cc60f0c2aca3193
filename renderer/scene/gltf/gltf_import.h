// glTF 2.0, as .gltf or .glb -> triangles in the world of their scene.
//
// The file's default scene (or its first; without any, every node without a parent), with the
// transforms of all nodes; triangles, strips and fans. Base colour and emission, factors and
// textures; COLOR_0; alphaMode MASK (BLEND: holes where alpha is below 0.5); samplers' wrap modes;
// KHR_materials_emissive_strength, KHR_texture_transform, KHR_mesh_quantization,
// KHR_materials_unlit (as any surface) and the directional lights of KHR_lights_punctual. Skins,
// morphs and animations stand still as the nodes have them; other lights are left out: warnings.
// Units: metres; emission and lux times `emission_scale`. tinygltf reads what gltf_document.h has
// checked. Source: glTF 2.0 (Khronos).
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "scene/mesh_parts.h"

namespace probebake {

struct GltfParams {
    /// W·m⁻²·sr⁻¹ for 1 nit of emission, and W·m⁻² for 1 lux of a light. 1 takes the file's numbers
    /// as they stand; photometric files want 1/683.
    double emission_scale = 1.0;
    MeshLimits limits;
};

/// Throws IoError, naming `file` and the JSON pointer or the offset, for everything that is
/// malformed, missing (but textures), not understood or too large.
TriangleMesh import_gltf(std::span<const std::byte> bytes, const GltfParams& params,
                         const ReadInner& read, const std::string& file);

}  // namespace probebake
