// What every importer of meshes promises about its result.
#pragma once

#include <cmath>
#include <cstdlib>

#include "mesh/triangle_mesh.h"

inline void require(bool holds) {
    if (!holds) std::abort();
}

inline void require_sound(const probebake::TriangleMesh& mesh) {
    using namespace probebake;
    require(mesh.texture_coordinates.empty() ||
            mesh.texture_coordinates.size() == mesh.positions.size());
    require(mesh.colors.empty() || mesh.colors.size() == mesh.positions.size());
    for (const Vec3& p : mesh.positions) require(is_finite(p));
    for (const Vec2& uv : mesh.texture_coordinates) require(is_finite(Vec3(uv, 0.0)));
    for (const auto& color : mesh.colors) {
        for (const float x : color) require(x >= 0.0f && x <= 1.0f);
    }
    for (const MeshTriangle& triangle : mesh.triangles) {
        for (const uint32_t vertex : triangle.vertices) require(vertex < mesh.positions.size());
        require(triangle.material < mesh.materials.size());
    }
    const auto is_light = [](const Rgb& c) {
        return is_finite(Vec3(c)) && c.r >= 0.0f && c.g >= 0.0f && c.b >= 0.0f;
    };
    for (const MeshMaterial& material : mesh.materials) {
        const Rgb& color = material.base_color;
        require(is_light(color) && color.r <= 1.0f && color.g <= 1.0f && color.b <= 1.0f);
        require(is_light(material.emission));
        require(material.alpha >= 0.0f && material.alpha <= 1.0f && material.alpha_cutoff >= 0.0f);
        for (const auto& texture : {material.base_color_texture, material.emission_texture}) {
            require(!texture || *texture < mesh.textures.size());
        }
    }
    for (const Texture& texture : mesh.textures) {
        require(texture.width_px > 0 && texture.height_px > 0 &&
                texture.texels.size() ==
                    static_cast<size_t>(texture.width_px) * static_cast<size_t>(texture.height_px));
    }
    for (const MeshSun& sun : mesh.suns) {
        require(std::abs(glm::length(sun.direction) - 1.0) < 1e-6 && is_light(sun.irradiance));
    }
}
