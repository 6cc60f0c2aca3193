#include "mesh/mesh_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "math/box.h"
#include "math/shared_exponent.h"

namespace probebake {
namespace {

/// Where a cut-out is looked at: so many texels along an edge at most, then groups of texels.
constexpr double kMostTexels = 8.0;

bool is_color(const Rgb& c) {
    for (int i = 0; i < 3; ++i) {
        if (!(c[i] >= 0.0f) || !std::isfinite(c[i])) return false;
    }
    return true;
}

void check(const TriangleMesh& mesh) {
    for (const MeshMaterial& material : mesh.materials) {
        if (!is_color(material.base_color) || !is_color(material.emission)) {
            throw std::invalid_argument("material \"" + material.name +
                                        "\" has a factor that is negative or not finite");
        }
        if (!(std::max({material.base_color.r, material.base_color.g, material.base_color.b}) <=
              kPackedRgbMax)) {
            throw std::invalid_argument("material \"" + material.name + "\" reflects too much");
        }
    }
    for (const std::array<float, 4>& c : mesh.colors) {
        if (!is_color({c[0], c[1], c[2]}) || !(c[0] <= 1.0f && c[1] <= 1.0f && c[2] <= 1.0f)) {
            throw std::invalid_argument("a vertex whose colour is not in 0 to 1");
        }
    }
}

}  // namespace

MeshSurface::MeshSurface(const TriangleMesh& mesh, const GridMesh& grid) : mesh_(mesh) {
    check(mesh);
    const size_t count = mesh.textures.size();
    std::vector<bool> used(mesh.materials.size());
    for (const GridTriangle& triangle : grid.triangles) used[triangle.material] = true;
    std::vector<uint8_t> plain(count);
    std::vector<uint8_t> cut_out(count);
    for (size_t i = 0; i < mesh.materials.size(); ++i) {
        const MeshMaterial& m = mesh.materials[i];
        if (!used[i]) continue;
        if (m.base_color_texture) {
            (m.alpha_cutoff > 0.0f ? cut_out : plain)[*m.base_color_texture] = 1;
        }
        const float most = std::max({m.emission.r, m.emission.g, m.emission.b});
        if (m.emission_texture && most > 0.0f) plain[*m.emission_texture] = 1;
        most_emission_ = std::max(most_emission_, most);
    }
    plain_.resize(count);
    cut_outs_.resize(count);
    tbb::parallel_for(size_t{0}, 2 * count, [&](size_t i) {
        const Texture& texture = mesh.textures[i / 2];
        if (texture.texels.empty()) return;
        if (i % 2 == 0 && plain[i / 2] != 0) {
            plain_[i / 2] = std::make_unique<TexturePyramid>(texture, false);
        }
        if (i % 2 == 1 && cut_out[i / 2] != 0) {
            cut_outs_[i / 2] = std::make_unique<TexturePyramid>(texture, true);
        }
    });
}

const TexturePyramid* MeshSurface::base_pyramid(const MeshMaterial& of) const {
    if (!of.base_color_texture) return nullptr;
    return (of.alpha_cutoff > 0.0f ? cut_outs_ : plain_)[*of.base_color_texture].get();
}

Vec2 MeshSurface::uv(const GridTriangle& triangle, const Vec3& barycentric) const {
    if (mesh_.texture_coordinates.empty()) return Vec2(0.0);
    Vec2 sum(0.0);
    for (size_t i = 0; i < 3; ++i) {
        sum += barycentric[static_cast<int>(i)] * mesh_.texture_coordinates[triangle.corners[i]];
    }
    return std::isfinite(sum.x) && std::isfinite(sum.y) ? sum : Vec2(0.0);
}

glm::vec4 MeshSurface::vertex_color(const GridTriangle& triangle, const Vec3& barycentric) const {
    if (mesh_.colors.empty()) return glm::vec4(1.0f);
    glm::vec4 sum(0.0f);
    for (size_t i = 0; i < 3; ++i) {
        const std::array<float, 4>& c = mesh_.colors[triangle.corners[i]];
        sum += static_cast<float>(barycentric[static_cast<int>(i)]) *
               glm::vec4(c[0], c[1], c[2], c[3]);
    }
    return glm::max(sum, glm::vec4(0.0f));
}

Rgba MeshSurface::texture_mean(const TexturePyramid& pyramid, const GridTriangle& triangle,
                               const Vec3& barycentric, double footprint) const {
    const std::array<Vec3, 3> p = corners_of(triangle);
    const Vec3 e1 = p[1] - p[0];
    const Vec3 e2 = p[2] - p[0];
    const Vec3 normal = glm::cross(e1, e2);
    const double size2 = glm::dot(normal, normal);
    glm::dmat2 spread(0.0);
    if (size2 > 0.0 && !mesh_.texture_coordinates.empty()) {
        // Gradients of the barycentric coordinates, and with them those of the texture's.
        const Vec3 g1 = glm::cross(e2, normal) / size2;
        const Vec3 g2 = glm::cross(normal, e1) / size2;
        const auto& t = mesh_.texture_coordinates;
        const Vec2 d1 = t[triangle.corners[1]] - t[triangle.corners[0]];
        const Vec2 d2 = t[triangle.corners[2]] - t[triangle.corners[0]];
        const Vec2 half = 0.5 * footprint * pyramid.size();
        const Vec3 du = half.x * (d1.x * g1 + d2.x * g2);
        const Vec3 dv = half.y * (d1.y * g1 + d2.y * g2);
        spread = {glm::dot(du, du), glm::dot(du, dv), glm::dot(du, dv), glm::dot(dv, dv)};
        if (!std::isfinite(spread[0][0] + spread[1][1])) spread = glm::dmat2(0.0);
    }
    const Vec2 at = uv(triangle, barycentric);
    Rgba mean = pyramid.mean(at, spread);
    // A point in a hole, and nothing but hole around it: as far as it takes.
    for (int i = 0; i < 2 * pyramid.levels() && !(mean.a > 0.0f); ++i) {
        spread = 4.0 * spread + glm::dmat2(1.0);
        mean = pyramid.mean(at, spread);
    }
    return mean;
}

Rgb MeshSurface::albedo(const GridTriangle& triangle, const Vec3& barycentric,
                        double footprint) const {
    const MeshMaterial& m = material(triangle);
    Rgb color = m.base_color * Rgb(vertex_color(triangle, barycentric));
    if (const TexturePyramid* const pyramid = base_pyramid(m)) {
        const Rgba mean = texture_mean(*pyramid, triangle, barycentric, footprint);
        if (mean.a > 0.0f) color *= Rgb(mean) / mean.a;
    }
    return color;
}

Rgb MeshSurface::emission(const GridTriangle& triangle, const Vec3& barycentric,
                          double footprint) const {
    const MeshMaterial& m = material(triangle);
    if (!m.emission_texture || !plain_[*m.emission_texture]) return m.emission;
    return m.emission *
           Rgb(texture_mean(*plain_[*m.emission_texture], triangle, barycentric, footprint));
}

bool MeshSurface::emits(const GridTriangle& triangle) const {
    return material(triangle).emission != Rgb(0.0f);
}

bool MeshSurface::shines_on_both_sides(const GridTriangle& triangle) const {
    return material(triangle).double_sided;
}

bool MeshSurface::has_holes(const GridTriangle& triangle) const {
    return material(triangle).alpha_cutoff > 0.0f;
}

bool MeshSurface::is_there_at_level(const GridTriangle& triangle, const Vec3& barycentric,
                                    int level) const {
    const MeshMaterial& m = material(triangle);
    if (!(m.alpha_cutoff > 0.0f)) return true;
    float alpha = m.alpha * vertex_color(triangle, barycentric).a;
    if (const TexturePyramid* const pyramid = base_pyramid(m)) {
        alpha *= pyramid->largest_alpha(uv(triangle, barycentric), level);
    }
    return alpha >= m.alpha_cutoff;
}

bool MeshSurface::is_there(const GridTriangle& triangle, const Vec3& barycentric) const {
    return is_there_at_level(triangle, barycentric, 0);
}

bool MeshSurface::is_any_there(const GridTriangle& triangle, const ClippedTriangle& part) const {
    if (part.size() == 0) return false;
    const TexturePyramid* const pyramid = base_pyramid(material(triangle));
    double texels = 1.0;
    if (pyramid != nullptr) {
        Vec2 low(kInfinity);
        Vec2 high(-kInfinity);
        for (size_t i = 0; i < part.size(); ++i) {
            const Vec2 at = uv(triangle, part[i].barycentric) * pyramid->size();
            low = glm::min(low, at);
            high = glm::max(high, at);
        }
        texels = std::max({1.0, high.x - low.x, high.y - low.y});
    }
    int level = 0;
    if (pyramid != nullptr && texels > kMostTexels) {
        level = std::min(static_cast<int>(std::ceil(std::log2(texels / kMostTexels))),
                         pyramid->levels() - 1);
    }
    // Two points to a texel or group, along both edges of each part of a fan.
    const int points = static_cast<int>(std::ceil(2.0 * std::min(texels, kMostTexels)));
    for (size_t k = 1; k == 1 || k + 1 < part.size(); ++k) {
        const Vec3& a = part[0].barycentric;
        const Vec3 b = part[std::min(k, part.size() - 1)].barycentric - a;
        const Vec3 c = part[std::min(k + 1, part.size() - 1)].barycentric - a;
        for (int i = 0; i <= points; ++i) {
            for (int j = 0; i + j <= points; ++j) {
                const Vec3 at = a + (double(i) / points) * b + (double(j) / points) * c;
                if (is_there_at_level(triangle, at, level)) return true;
            }
        }
    }
    return false;
}

uint64_t MeshSurface::memory_bytes() const {
    uint64_t bytes = 0;
    for (const auto* pyramids : {&plain_, &cut_outs_}) {
        for (const auto& pyramid : *pyramids) {
            if (pyramid) bytes += pyramid->memory_bytes();
        }
    }
    return bytes;
}

}  // namespace probebake
