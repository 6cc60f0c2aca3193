#include "scene/gltf/gltf_import.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "math/affine.h"
#include "scene/gltf/gltf_accessor.h"
#include "scene/gltf/gltf_document.h"
#include "scene/gltf/gltf_load.h"
#include "scene/gltf/gltf_materials.h"

namespace probebake {
namespace {

class Import {
  public:
    Import(const tinygltf::Model& model, const GltfParams& params, const ReadInner& read,
           const std::string& file, TriangleMesh& mesh)
        : model_(model),
          params_(params),
          file_(file),
          mesh_(mesh),
          textures_(mesh, read, params.limits, file) {}

    void run() {
        for (const std::string& extension : model_.extensionsUsed) {
            if (!gltf_understands(extension)) {
                warn(mesh_, "the extension " + extension.substr(0, 100) + " is left out");
            }
        }
        coordinates_ = add_materials(model_, params_.emission_scale, textures_, file_, mesh_);
        if (!model_.animations.empty()) warn(mesh_, "animations are left out");
        walk();
    }

  private:
    struct Placed {
        int node = 0;
        Affine to_world;
    };
    /// Accessors of positions, coordinates and colours (−1: none), and where the map of the
    /// coordinates comes from.
    using Shared = std::tuple<int, int, int, std::array<double, 6>>;

    [[noreturn]] void fail(const std::string& pointer, const std::string& problem) const {
        throw IoError(file_, pointer + ": " + problem);
    }
    static std::string pointer_of(int node) { return "/nodes/" + std::to_string(node); }

    std::vector<int> roots() const {
        if (!model_.scenes.empty()) {
            return model_.scenes[static_cast<size_t>(std::max(0, model_.defaultScene))].nodes;
        }
        std::vector<bool> is_child(model_.nodes.size());
        for (const tinygltf::Node& node : model_.nodes) {
            for (const int child : node.children) is_child[static_cast<size_t>(child)] = true;
        }
        std::vector<int> found;
        for (size_t i = 0; i < is_child.size(); ++i) {
            if (!is_child[i]) found.push_back(static_cast<int>(i));
        }
        return found;
    }

    void walk() {
        std::vector<bool> seen(model_.nodes.size());
        std::vector<Placed> open;
        const auto push = [&](const std::vector<int>& nodes, const Affine& parent) {
            // The last first: the stack gives them back in the file's order.
            for (auto at = nodes.rbegin(); at != nodes.rend(); ++at) {
                const auto index = static_cast<size_t>(*at);
                if (seen[index]) fail(pointer_of(*at), "is met twice, but nodes form trees");
                seen[index] = true;
                open.push_back({*at, parent.after(transform_of(*at))});
            }
        };
        push(roots(), Affine{});
        while (!open.empty()) {
            const Placed placed = open.back();
            open.pop_back();
            const tinygltf::Node& node = model_.nodes[static_cast<size_t>(placed.node)];
            if (node.mesh >= 0) add_mesh(placed, node);
            add_light(placed, node);
            push(node.children, placed.to_world);
        }
    }

    Affine transform_of(int index) const {
        const tinygltf::Node& node = model_.nodes[static_cast<size_t>(index)];
        Affine made;
        if (!node.matrix.empty()) {
            const std::vector<double>& m = node.matrix;  // column by column
            if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) {
                fail(pointer_of(index) + "/matrix", "expected 0, 0, 0, 1 in its last row");
            }
            made.linear = glm::dmat3(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
            made.offset = Vec3(m[12], m[13], m[14]);
            return made;
        }
        if (!node.rotation.empty()) made.linear = rotation_of(index, node.rotation);
        if (!node.scale.empty()) {
            for (int axis = 0; axis < 3; ++axis) {
                made.linear[axis] *= node.scale[static_cast<size_t>(axis)];
            }
        }
        if (!node.translation.empty()) {
            made.offset = Vec3(node.translation[0], node.translation[1], node.translation[2]);
        }
        return made;
    }

    /// Of a quaternion x, y, z, w.
    glm::dmat3 rotation_of(int index, const std::vector<double>& q) const {
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (!(length > 1e-6 && length < 1e6)) {
            fail(pointer_of(index) + "/rotation", "expected a quaternion of length 1");
        }
        const double x = q[0] / length;
        const double y = q[1] / length;
        const double z = q[2] / length;
        const double w = q[3] / length;
        return {
            1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z),       2.0 * (x * z - w * y),
            2.0 * (x * y - w * z),       1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x),
            2.0 * (x * z + w * y),       2.0 * (y * z - w * x),       1.0 - 2.0 * (x * x + y * y)};
    }

    void add_light(const Placed& placed, const tinygltf::Node& node) {
        const auto at = node.extensions.find("KHR_lights_punctual");
        if (at == node.extensions.end() || !at->second.Has("light")) return;
        const int index = at->second.Get("light").GetNumberAsInt();
        const tinygltf::Light& light = model_.lights[static_cast<size_t>(index)];
        if (light.type != "directional") {
            warn(mesh_, pointer_of(placed.node) + ": lights other than directional are left out");
            return;
        }
        const Vec3 direction = placed.to_world.vector(Vec3(0.0, 0.0, -1.0));
        const double length = glm::length(direction);
        if (!(length > 0.0 && std::isfinite(length))) {
            fail(pointer_of(placed.node), "its light has no direction");
        }
        const Vec3 color =
            light.color.empty() ? Vec3(1.0) : Vec3(light.color[0], light.color[1], light.color[2]);
        mesh_.suns.push_back(
            {direction / length, checked_emission(color * light.intensity * params_.emission_scale,
                                                  pointer_of(placed.node) + ": its light", file_)});
    }

    void add_mesh(const Placed& placed, const tinygltf::Node& node) {
        const tinygltf::Mesh& from = model_.meshes[static_cast<size_t>(node.mesh)];
        if (node.skin >= 0) warn(mesh_, "skins are left out: meshes stand as they were modelled");
        const std::string pointer = "/meshes/" + std::to_string(node.mesh) + "/primitives/";
        std::map<Shared, uint32_t> shared;
        for (size_t i = 0; i < from.primitives.size(); ++i) {
            add_primitive(placed, from.primitives[i], pointer + std::to_string(i), shared);
        }
    }

    void add_primitive(const Placed& placed, const tinygltf::Primitive& primitive,
                       const std::string& pointer, std::map<Shared, uint32_t>& shared) {
        if (primitive.mode < TINYGLTF_MODE_TRIANGLES ||
            primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
            if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
                fail(pointer + "/mode", "expected 0 to 6");
            }
            warn(mesh_, "points and lines are left out");
            return;
        }
        if (!primitive.targets.empty()) warn(mesh_, "morph targets are left out");
        const auto attribute = [&](const std::string& name) {
            const auto at = primitive.attributes.find(name);
            return at == primitive.attributes.end() ? -1 : at->second;
        };
        const int position = attribute("POSITION");
        if (position < 0) fail(pointer + "/attributes", "expected a POSITION");
        const uint32_t material = material_of(primitive);
        const GltfCoordinates& coordinates = coordinates_[material];
        const int uv = needs_coordinates(material)
                           ? attribute("TEXCOORD_" + std::to_string(coordinates.set))
                           : -1;
        if (uv < 0 && needs_coordinates(material)) {
            warn(mesh_, pointer + " has no TEXCOORD_" + std::to_string(coordinates.set) +
                            ": it shows one texel of its texture");
        }
        const GltfAccessor positions(model_, position, params_.limits.max_vertices, file_);
        const int color = attribute("COLOR_0");
        const auto [at, is_new] = shared.try_emplace({position, uv, color, coordinates.map},
                                                     static_cast<uint32_t>(mesh_.positions.size()));
        if (is_new) {
            add_positions(positions, placed.to_world);
            if (uv >= 0) add_coordinates(uv, coordinates, positions.size());
            if (color >= 0) add_colors(color, positions.size());
        }
        pad();
        const bool mirrored = glm::determinant(placed.to_world.linear) < 0.0;
        add_triangles(primitive, {at->second, material, positions.size(), mirrored});
    }

    uint32_t material_of(const tinygltf::Primitive& primitive) {
        if (primitive.material >= 0) return static_cast<uint32_t>(primitive.material);
        if (!default_material_) {
            default_material_ = static_cast<uint32_t>(mesh_.materials.size());
            mesh_.materials.push_back({.name = "default", .double_sided = false});
            coordinates_.emplace_back();
        }
        return *default_material_;
    }
    bool needs_coordinates(uint32_t material) const {
        return mesh_.materials[material].base_color_texture ||
               mesh_.materials[material].emission_texture;
    }

    void add_positions(const GltfAccessor& from, const Affine& to_world) {
        const bool quantized = !from.is_float();
        const std::vector<std::string>& required = model_.extensionsRequired;
        if (from.components() != 3) from.fail("is a position, expected a VEC3");
        if (from.is_empty()) from.fail("is a position without data");
        if (quantized && std::find(required.begin(), required.end(), "KHR_mesh_quantization") ==
                             required.end()) {
            from.fail("is a position, expected floats");
        }
        require_vertices(mesh_.positions.size() + from.size(), params_.limits, file_);
        for (size_t i = 0; i < from.size(); ++i) {
            const Vec3 point =
                to_world.point(Vec3(from.value(i, 0), from.value(i, 1), from.value(i, 2)));
            if (!is_finite(point)) from.fail("position " + std::to_string(i) + " is not finite");
            mesh_.positions.push_back(point);
        }
    }
    void add_coordinates(int accessor, const GltfCoordinates& coordinates, size_t count) {
        const GltfAccessor from(model_, accessor, params_.limits.max_vertices, file_);
        if (from.components() != 2) from.fail("is a texture coordinate, expected a VEC2");
        require_count(from, count);
        mesh_.texture_coordinates.resize(mesh_.positions.size() - count, Vec2(0.0));
        for (size_t i = 0; i < count; ++i) {
            const Vec2 uv = coordinates.mapped({from.value(i, 0), from.value(i, 1)});
            if (!is_finite(Vec3(uv, 0.0))) {
                from.fail("texture coordinate " + std::to_string(i) + " is not finite");
            }
            mesh_.texture_coordinates.push_back(uv);
        }
    }
    void add_colors(int accessor, size_t count) {
        const GltfAccessor from(model_, accessor, params_.limits.max_vertices, file_);
        if (from.components() < 3 || !(from.is_float() || from.is_normalized())) {
            from.fail("is a colour, expected a VEC3 or VEC4 of floats or normalised integers");
        }
        require_count(from, count);
        mesh_.colors.resize(mesh_.positions.size() - count, kWhite);
        for (size_t i = 0; i < count; ++i) {
            std::array<float, 4> color = kWhite;
            for (int channel = 0; channel < from.components(); ++channel) {
                const double x = from.value(i, channel);
                // Exporters write a little more than 1.
                if (!(x >= 0.0 && x <= 1.001)) {
                    from.fail("colour " + std::to_string(i) + " is not from 0 to 1");
                }
                color[static_cast<size_t>(channel)] = static_cast<float>(std::min(x, 1.0));
            }
            mesh_.colors.push_back(color);
        }
    }
    static void require_count(const GltfAccessor& from, size_t count) {
        if (from.size() != count) {
            from.fail("has " + std::to_string(from.size()) + " elements, but there are " +
                      std::to_string(count) + " positions");
        }
    }
    /// Vertices that have no coordinates or colours of their own get neutral ones.
    void pad() {
        const size_t count = mesh_.positions.size();
        if (!mesh_.texture_coordinates.empty()) {
            mesh_.texture_coordinates.resize(count, Vec2(0.0));
        }
        if (!mesh_.colors.empty()) mesh_.colors.resize(count, kWhite);
    }

    struct Part {
        uint32_t first_vertex = 0;
        uint32_t material = 0;
        size_t vertices = 0;
        bool mirrored = false;
    };
    void add_triangles(const tinygltf::Primitive& primitive, const Part& part) {
        std::optional<GltfAccessor> indices;
        if (primitive.indices >= 0) {
            // As many as the triangles of a list could need.
            indices.emplace(model_, primitive.indices, 3 * params_.limits.max_triangles, file_);
            if (indices->components() != 1 || !indices->is_unsigned()) {
                indices->fail("is an index, expected an unsigned SCALAR");
            }
        }
        const size_t count = indices ? indices->size() : part.vertices;
        const bool is_list = primitive.mode == TINYGLTF_MODE_TRIANGLES;
        const size_t triangles = is_list ? count / 3 : count - std::min<size_t>(count, 2);
        require_triangles(mesh_.triangles.size() + triangles, params_.limits, file_);
        const auto vertex = [&](size_t i) {
            const uint64_t at = indices ? indices->integer(i) : i;
            if (at >= part.vertices) {
                indices->fail("element " + std::to_string(i) + " is index " + std::to_string(at) +
                              ", but there are " + std::to_string(part.vertices) + " positions");
            }
            return part.first_vertex + static_cast<uint32_t>(at);
        };
        for (size_t i = 0; i < triangles; ++i) {
            std::array<size_t, 3> corners{3 * i, 3 * i + 1, 3 * i + 2};
            if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
                corners = {i, i + 1 + i % 2, i + 2 - i % 2};
            } else if (primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
                corners = {i + 1, i + 2, 0};
            }
            if (part.mirrored) std::swap(corners[1], corners[2]);
            mesh_.triangles.push_back(
                {{vertex(corners[0]), vertex(corners[1]), vertex(corners[2])}, part.material});
        }
    }

    static constexpr std::array<float, 4> kWhite{1.0f, 1.0f, 1.0f, 1.0f};

    const tinygltf::Model& model_;
    const GltfParams& params_;
    const std::string& file_;
    TriangleMesh& mesh_;
    MeshTextures textures_;
    std::vector<GltfCoordinates> coordinates_;  // one per material
    std::optional<uint32_t> default_material_;
};

}  // namespace

TriangleMesh import_gltf(std::span<const std::byte> bytes, const GltfParams& params,
                         const ReadInner& read, const std::string& file) {
    TriangleMesh mesh;
    const tinygltf::Model model = load_gltf(bytes, read, file, mesh.warnings);
    Import(model, params, read, file, mesh).run();
    return mesh;
}

}  // namespace probebake
