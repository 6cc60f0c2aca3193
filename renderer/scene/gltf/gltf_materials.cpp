#include "scene/gltf/gltf_materials.h"

#include <cmath>

#include "io/io_error.h"
#include "scene/gltf/gltf_document.h"

namespace probebake {
namespace {

std::string pointer_of(const char* section, size_t index) {
    return "/" + std::string(section) + "/" + std::to_string(index);
}

TextureWrap wrap_of(int mode, const std::string& pointer, const std::string& file) {
    switch (mode) {
        case TINYGLTF_TEXTURE_WRAP_REPEAT:
            return TextureWrap::kRepeat;
        case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
            return TextureWrap::kClamp;
        case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
            return TextureWrap::kMirror;
        default:
            throw IoError(file, pointer + ": wraps by " + std::to_string(mode) +
                                    ", expected 10497, 33071 or 33648");
    }
}

std::optional<uint32_t> load_texture(const tinygltf::Model& model, int index,
                                     MeshTextures& textures, const std::string& file,
                                     TriangleMesh& mesh) {
    const tinygltf::Texture& texture = model.textures[static_cast<size_t>(index)];
    TextureWrap wrap_u = TextureWrap::kRepeat;
    TextureWrap wrap_v = TextureWrap::kRepeat;
    if (texture.sampler >= 0) {
        const auto sampler = static_cast<size_t>(texture.sampler);
        const std::string pointer = pointer_of("samplers", sampler);
        wrap_u = wrap_of(model.samplers[sampler].wrapS, pointer + "/wrapS", file);
        wrap_v = wrap_of(model.samplers[sampler].wrapT, pointer + "/wrapT", file);
    }
    if (texture.source < 0) {
        warn(mesh, pointer_of("textures", static_cast<size_t>(index)) +
                       " has no PNG or JPEG: the material's factor is taken alone");
        return std::nullopt;
    }
    const auto source = static_cast<size_t>(texture.source);
    const tinygltf::Image& image = model.images[source];
    const std::string pointer = pointer_of("images", source);
    if (!image.uri.empty()) {
        const auto name = name_of_uri(image.uri, pointer + "/uri", file);
        if (name) return textures.from_file(*name, wrap_u, wrap_v);
    }
    // A data: URI of another kind has left no bytes: neither PNG nor JPEG.
    return textures.from_bytes(std::as_bytes(std::span(image.image)), file + ": " + pointer, wrap_u,
                               wrap_v);
}

double number_of(const tinygltf::Value& value, const char* key, double otherwise) {
    return value.Has(key) ? value.Get(key).GetNumberAsDouble() : otherwise;
}

GltfCoordinates coordinates_of(const tinygltf::TextureInfo& texture) {
    GltfCoordinates found{.set = texture.texCoord};
    const auto at = texture.extensions.find("KHR_texture_transform");
    if (at == texture.extensions.end()) return found;
    const tinygltf::Value& value = at->second;
    const auto pair = [&](const char* key, double otherwise) {
        if (!value.Has(key)) return Vec2(otherwise);
        const tinygltf::Value& numbers = value.Get(key);
        return Vec2(numbers.Get(0).GetNumberAsDouble(), numbers.Get(1).GetNumberAsDouble());
    };
    const Vec2 scale = pair("scale", 1.0);
    const Vec2 offset = pair("offset", 0.0);
    const double angle = number_of(value, "rotation", 0.0);
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    // Scaled, turned, shifted. Counter-clockwise as the extension's text says and its test model
    // wants, in coordinates of which v points down; its sample code has the other sign (Khronos'
    // issue glTF 1563).
    found.map = {c * scale.x, -s * scale.x, s * scale.y, c * scale.y, offset.x, offset.y};
    found.set = value.Has("texCoord") ? value.Get("texCoord").GetNumberAsInt() : found.set;
    return found;
}

void read_alpha(const tinygltf::Material& from, const std::string& pointer, const std::string& file,
                MeshMaterial& to, TriangleMesh& mesh) {
    const double alpha = from.pbrMetallicRoughness.baseColorFactor[3];
    if (!(alpha >= 0.0 && alpha <= 1.0) || !(from.alphaCutoff >= 0.0)) {
        throw IoError(file, pointer + ": alpha is no number from 0 to 1, or its cutoff below 0");
    }
    to.alpha = static_cast<float>(alpha);
    if (from.alphaMode == "MASK") {
        to.alpha_cutoff = static_cast<float>(from.alphaCutoff);
    } else if (from.alphaMode == "BLEND") {
        to.alpha_cutoff = 0.5f;
        warn(mesh, pointer + " is blended: it is a hole where alpha is below 0.5");
    }
}

Vec3 emission_of(const tinygltf::Material& from, double emission_scale) {
    const auto& factor = from.emissiveFactor;
    double strength = emission_scale;
    const auto at = from.extensions.find("KHR_materials_emissive_strength");
    if (at != from.extensions.end()) strength *= number_of(at->second, "emissiveStrength", 1.0);
    return Vec3(factor[0], factor[1], factor[2]) * strength;
}

}  // namespace

std::vector<GltfCoordinates> add_materials(const tinygltf::Model& model, double emission_scale,
                                           MeshTextures& textures, const std::string& file,
                                           TriangleMesh& mesh) {
    std::vector<GltfCoordinates> coordinates;
    for (size_t i = 0; i < model.materials.size(); ++i) {
        const tinygltf::Material& from = model.materials[i];
        const std::string pointer = pointer_of("materials", i);
        const auto& surface = from.pbrMetallicRoughness;
        const auto& color = surface.baseColorFactor;
        MeshMaterial to{.name = from.name, .double_sided = from.doubleSided};
        to.base_color = checked_reflectance(Vec3(color[0], color[1], color[2]),
                                            pointer + ": baseColorFactor", file, mesh);
        to.emission =
            checked_emission(emission_of(from, emission_scale), pointer + ": emission", file);
        read_alpha(from, pointer, file, to, mesh);
        if (surface.baseColorTexture.index >= 0) {
            to.base_color_texture =
                load_texture(model, surface.baseColorTexture.index, textures, file, mesh);
        }
        if (from.emissiveTexture.index >= 0 && to.emission != Rgb(0.0f)) {
            to.emission_texture =
                load_texture(model, from.emissiveTexture.index, textures, file, mesh);
        }
        GltfCoordinates own = coordinates_of(surface.baseColorTexture);
        if (to.emission_texture) {
            const GltfCoordinates emitted = coordinates_of(from.emissiveTexture);
            if (!to.base_color_texture) {
                own = emitted;
            } else if (emitted != own) {
                warn(mesh, pointer +
                               ": the emissive texture lies where the base colour's does, not at "
                               "coordinates of its own");
            }
        }
        coordinates.push_back(own);
        mesh.materials.push_back(std::move(to));
    }
    return coordinates;
}

}  // namespace probebake
