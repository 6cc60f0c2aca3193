#include "scene/obj/obj_import.h"

#include <sstream>
#include <unordered_map>

#define TINYOBJLOADER_IMPLEMENTATION
#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>

#include "scene/obj/obj_text.h"
#include "scene/triangulate_polygon.h"

namespace probebake {
namespace {

std::string_view text_of(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The materials of all files, one after the other, and the files that are missing.
struct Materials {
    MtlText mtl;
    std::vector<std::string> files;
    std::vector<std::string> missing;
};

void append(Materials& materials, const std::string& name, const std::vector<std::byte>& bytes) {
    MtlText more = check_mtl(text_of(bytes), name);
    materials.mtl.text += more.text;
    materials.mtl.with_kd.merge(more.with_kd);
    std::move(more.textures.begin(), more.textures.end(),
              std::back_inserter(materials.mtl.textures));
    materials.mtl.has_options |= more.has_options;
}

/// A line of mtllib names one file with spaces in its name, or several.
Materials read_materials(const std::vector<std::string>& lines, const ObjParams& params,
                         const ReadInner& read, const std::string& file) {
    Materials found;
    const auto take = [&](std::string name, const std::string& named_by) {
        std::replace(name.begin(), name.end(), '\\', '/');
        const auto bytes = read_inner(read, name, named_by);
        if (bytes) append(found, name, *bytes);
        found.files.push_back(name);
        if (!bytes) found.missing.push_back(name);
        return bytes.has_value();
    };
    if (params.materials) {
        take(*params.materials, file);
        return found;
    }
    for (const std::string& line : lines) {
        std::istringstream words(line);
        const bool several = line.find_first_of(" \t") != std::string::npos;
        if (take(line, file) || !several) continue;
        found.missing.pop_back();
        for (std::string name; words >> name;) take(name, file);
    }
    return found;
}

/// What tinyobjloader calls back with.
struct Parsed {
    struct Corner {
        int position = 0;  // 0-based
        int coordinate = -1;
    };
    struct Face {
        uint32_t corners = 0;
        int material = -1;
    };
    std::vector<Vec3> positions;
    std::vector<Vec2> coordinates;
    std::vector<Corner> corners;
    std::vector<Face> faces;
    std::vector<tinyobj::material_t> materials;
    std::vector<std::string> unknown_materials;
    int material = -1;
};

class MaterialText : public tinyobj::MaterialReader {
  public:
    explicit MaterialText(const std::string& text) : text_(text) {}
    bool operator()(const std::string&, std::vector<tinyobj::material_t>* materials,
                    std::map<std::string, int>* names, std::string* warning,
                    std::string* error) override {
        std::istringstream stream(text_);
        tinyobj::LoadMtl(names, materials, &stream, warning, error);
        return true;
    }

  private:
    const std::string& text_;
};

tinyobj::callback_t callbacks() {
    tinyobj::callback_t calls;
    calls.vertex_cb = [](void* parsed, double x, double y, double z, double) {
        static_cast<Parsed*>(parsed)->positions.emplace_back(x, y, z);
    };
    calls.texcoord_cb = [](void* parsed, double u, double v, double) {
        static_cast<Parsed*>(parsed)->coordinates.emplace_back(u, 1.0 - v);
    };
    calls.index_cb = [](void* user, tinyobj::index_t* indices, int count) {
        auto& parsed = *static_cast<Parsed*>(user);
        const auto from_zero = [](int index, size_t size) {  // 0: there is none
            return index < 0 ? static_cast<int>(size) + index : index - 1;
        };
        for (int i = 0; i < count; ++i) {
            parsed.corners.push_back(
                {from_zero(indices[i].vertex_index, parsed.positions.size()),
                 from_zero(indices[i].texcoord_index, parsed.coordinates.size())});
        }
        parsed.faces.push_back({static_cast<uint32_t>(count), parsed.material});
    };
    calls.usemtl_cb = [](void* user, const char* name, int material) {
        auto& parsed = *static_cast<Parsed*>(user);
        parsed.material = material;
        if (material < 0) parsed.unknown_materials.emplace_back(name);
    };
    calls.mtllib_cb = [](void* parsed, const tinyobj::material_t* materials, int count) {
        static_cast<Parsed*>(parsed)->materials.assign(materials, materials + count);
    };
    return calls;
}

Parsed parse(ObjText& obj, const std::string& mtl, const std::string& file) {
    Parsed parsed;
    parsed.positions.reserve(obj.vertices);
    parsed.coordinates.reserve(obj.texture_coordinates);
    MaterialText materials(mtl);
    std::istringstream stream((mtl.empty() ? "" : "mtllib checked\n") +
                              std::exchange(obj.text, {}));
    std::string warning;
    std::string error;
    if (!tinyobj::LoadObjWithCallback(stream, callbacks(), &parsed, &materials, &warning, &error) ||
        !error.empty()) {
        throw IoError(file, "cannot be read: " + error);
    }
    for (size_t i = 0; i < parsed.positions.size(); ++i) {
        if (!is_finite(parsed.positions[i])) {
            throw IoError(file, "vertex " + std::to_string(i + 1) + " is not finite");
        }
    }
    for (size_t i = 0; i < parsed.coordinates.size(); ++i) {
        if (!is_finite(Vec3(parsed.coordinates[i], 0.0))) {
            throw IoError(file, "texture coordinate " + std::to_string(i + 1) + " is not finite");
        }
    }
    return parsed;
}

/// What is the same for all materials of a file.
struct MaterialSource {
    const MtlText& mtl;
    double emission_scale;
    const std::string& file;
};

MeshMaterial material_of(const tinyobj::material_t& from, const MaterialSource& source,
                         MeshTextures& textures, TriangleMesh& mesh) {
    const auto wrap = [](const tinyobj::texture_option_t& option) {
        return option.clamp ? TextureWrap::kClamp : TextureWrap::kRepeat;
    };
    const auto load = [&](const std::string& name, const tinyobj::texture_option_t& option) {
        return name.empty() ? std::nullopt : textures.from_file(name, wrap(option), wrap(option));
    };
    MeshMaterial to{.name = from.name};
    const std::string who = "the material \"" + from.name + "\"";
    to.base_color_texture = load(from.diffuse_texname, from.diffuse_texopt);
    const bool white = to.base_color_texture && !source.mtl.with_kd.contains(from.name);
    to.base_color =
        white ? Rgb(1.0f)
              : checked_reflectance(Vec3(from.diffuse[0], from.diffuse[1], from.diffuse[2]),
                                    who + ": Kd", source.file, mesh);
    to.emission_texture = load(from.emissive_texname, from.emissive_texopt);
    Vec3 emission(from.emission[0], from.emission[1], from.emission[2]);
    // Ke is 0 where the file does not say otherwise.
    if (to.emission_texture && emission == Vec3(0.0)) emission = Vec3(1.0);
    to.emission = checked_emission(emission * source.emission_scale, who + ": Ke", source.file);
    to.alpha = static_cast<float>(from.dissolve);
    if (from.dissolve < 1.0 || !from.alpha_texname.empty()) to.alpha_cutoff = 0.5f;
    if (!from.alpha_texname.empty() && from.alpha_texname != from.diffuse_texname) {
        warn(mesh, who + ": map_d is left out, as it is not the picture of map_Kd");
    }
    return to;
}

/// Corners that agree in position and texture coordinate become one vertex.
class Vertices {
  public:
    Vertices(const Parsed& parsed, const ObjParams& params, TriangleMesh& mesh,
             const std::string& file)
        : parsed_(parsed), params_(params), mesh_(mesh), file_(file) {}

    uint32_t of(const Parsed::Corner& corner) {
        const uint64_t key = static_cast<uint64_t>(corner.position) << 32 |
                             static_cast<uint64_t>(corner.coordinate + 1);
        const auto [at, is_new] =
            known_.try_emplace(key, static_cast<uint32_t>(mesh_.positions.size()));
        if (is_new) {
            require_vertices(mesh_.positions.size() + 1, params_.limits, file_);
            mesh_.positions.push_back(parsed_.positions[static_cast<size_t>(corner.position)]);
            if (!parsed_.coordinates.empty()) {
                mesh_.texture_coordinates.push_back(
                    corner.coordinate < 0
                        ? Vec2(0.0)
                        : parsed_.coordinates[static_cast<size_t>(corner.coordinate)]);
            }
        }
        return at->second;
    }

  private:
    const Parsed& parsed_;
    const ObjParams& params_;
    TriangleMesh& mesh_;
    const std::string& file_;
    std::unordered_map<uint64_t, uint32_t> known_;
};

void add_faces(const Parsed& parsed, const ObjParams& params, TriangleMesh& mesh,
               const std::string& file) {
    Vertices vertices(parsed, params, mesh, file);
    std::vector<Vec3> ring;
    std::span<const Parsed::Corner> corners = parsed.corners;
    const auto grey = static_cast<uint32_t>(parsed.materials.size());
    bool needs_grey = false;
    for (const Parsed::Face& face : parsed.faces) {
        const auto own = corners.first(face.corners);
        corners = corners.subspan(face.corners);
        ring.clear();
        for (const Parsed::Corner& corner : own) {
            ring.push_back(parsed.positions[static_cast<size_t>(corner.position)]);
        }
        const auto triangles = triangulate_polygon(ring);
        if (!triangles) {
            throw IoError(file, "a concave face has " + std::to_string(own.size()) +
                                    " corners, expected at most " +
                                    std::to_string(kMaxConcaveCorners));
        }
        needs_grey = needs_grey || face.material < 0;
        const uint32_t material = face.material < 0 ? grey : static_cast<uint32_t>(face.material);
        for (const auto& triangle : *triangles) {
            mesh.triangles.push_back({{vertices.of(own[triangle[0]]), vertices.of(own[triangle[1]]),
                                       vertices.of(own[triangle[2]])},
                                      material});
        }
    }
    if (needs_grey) {
        mesh.materials.push_back({.name = "none", .base_color = kNoMaterialAlbedo});
    }
}

}  // namespace

TriangleMesh import_obj(std::string_view text, const ObjParams& params, const ReadInner& read,
                        const std::string& file) {
    ObjText obj = check_obj(text, params.limits, file);
    TriangleMesh mesh;
    if (obj.has_colors) warn(mesh, "colours of vertices are left out");
    if (obj.has_others) warn(mesh, "lines, points, curves and surfaces are left out");
    const Materials materials = read_materials(obj.material_files, params, read, file);
    for (const std::string& name : materials.missing) {
        warn(mesh, "the material file \"" + name + "\" is missing: its materials are grey");
    }
    if (materials.mtl.has_options) {
        warn(mesh, "options of textures other than -clamp are left out");
    }
    const Parsed parsed = parse(obj, materials.mtl.text, file);
    for (const std::string& name : parsed.unknown_materials) {
        warn(mesh, "the material \"" + name + "\" is not defined: it is grey");
    }
    MeshTextures textures(mesh, read, params.limits, file);
    for (const tinyobj::material_t& material : parsed.materials) {
        mesh.materials.push_back(
            material_of(material, {materials.mtl, params.emission_scale, file}, textures, mesh));
    }
    add_faces(parsed, params, mesh, file);
    return mesh;
}

std::vector<std::string> obj_references(std::string_view text, const ObjParams& params,
                                        const ReadInner& read, const std::string& file) {
    Materials materials = read_materials(material_files_of(text, file), params, read, file);
    std::vector<std::string> names = std::move(materials.files);
    names.insert(names.end(), materials.mtl.textures.begin(), materials.mtl.textures.end());
    return names;
}

}  // namespace probebake
