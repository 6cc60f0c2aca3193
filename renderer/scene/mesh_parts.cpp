#include "scene/mesh_parts.h"

#include <algorithm>
#include <cmath>

#include "scene/picture/picture_file.h"

namespace probebake {
namespace {

void require_at_most(uint64_t count, uint64_t most, const char* what, const std::string& file) {
    if (count > most) {
        throw IoError(file, "has more than " + std::to_string(most) + " " + what);
    }
}

void require_positive(const Vec3& color, const std::string& what, const std::string& file) {
    for (int channel = 0; channel < 3; ++channel) {
        // Also where it is NaN, or no float.
        if (!(color[channel] >= 0.0 && color[channel] <= std::numeric_limits<float>::max())) {
            throw IoError(file, what + " is " + std::to_string(color[channel]) +
                                    ", expected a finite number of at least 0");
        }
    }
}

}  // namespace

void require_triangles(uint64_t count, const MeshLimits& limits, const std::string& file) {
    require_at_most(count, limits.max_triangles, "triangles", file);
}

void require_vertices(uint64_t count, const MeshLimits& limits, const std::string& file) {
    require_at_most(count, limits.max_vertices, "vertices", file);
}

Rgb checked_reflectance(const Vec3& color, const std::string& what, const std::string& file,
                        TriangleMesh& mesh) {
    require_positive(color, what, file);
    if (std::max({color.x, color.y, color.z}) > 1.0) {
        warn(mesh, what + " reflects more than it receives: 1 is taken instead");
    }
    return Rgb(glm::min(color, Vec3(1.0)));
}

Rgb checked_emission(const Vec3& color, const std::string& what, const std::string& file) {
    require_positive(color, what, file);
    return Rgb(color);
}

void warn(TriangleMesh& mesh, const std::string& warning) {
    constexpr size_t kMost = 100;
    auto& warnings = mesh.warnings;
    if (std::find(warnings.begin(), warnings.end(), warning) != warnings.end()) return;
    if (warnings.size() < kMost) warnings.push_back(warning);
    if (warnings.size() == kMost) warnings.back() = "further warnings are left out";
}

std::optional<uint32_t> MeshTextures::from_file(const std::string& name, TextureWrap wrap_u,
                                                TextureWrap wrap_v) {
    if (const auto at = known_.find({name, wrap_u, wrap_v}); at != known_.end()) return at->second;
    const auto bytes = read_inner(read_, name, file_);
    if (bytes) return from_bytes(*bytes, name, wrap_u, wrap_v);
    warn(mesh_, "the texture \"" + name + "\" is missing: the material's factor is taken alone");
    return known_[{name, wrap_u, wrap_v}] = std::nullopt;
}

std::optional<uint32_t> MeshTextures::from_bytes(std::span<const std::byte> bytes,
                                                 const std::string& name, TextureWrap wrap_u,
                                                 TextureWrap wrap_v) {
    const auto [at, is_new] = known_.try_emplace({name, wrap_u, wrap_v});
    if (!is_new) return at->second;
    if (!is_png_or_jpeg(bytes)) {
        warn(mesh_, "the texture \"" + name +
                        "\" is neither a PNG nor a JPEG: the material's factor is taken alone");
        return std::nullopt;
    }
    RgbaPicture picture = read_rgba_picture(bytes, name, limits_.max_texels - texels_);
    texels_ += picture.values.size();
    at->second = static_cast<uint32_t>(mesh_.textures.size());
    mesh_.textures.push_back({.width_px = picture.width_px,
                              .height_px = picture.height_px,
                              .texels = std::move(picture.values),
                              .wrap_u = wrap_u,
                              .wrap_v = wrap_v});
    return at->second;
}

}  // namespace probebake
