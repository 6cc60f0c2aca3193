#include "scene/mesh_file.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "io/file_beneath.h"
#include "math/box.h"
#include "objects/object_bounds.h"
#include "scene/folder_files.h"
#include "scene/gltf/gltf_document.h"
#include "scene/gltf/gltf_import.h"
#include "scene/nff/nff_mesh.h"
#include "scene/obj/obj_import.h"
#include "scene/scene_library.h"

namespace probebake {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;
/// Of a voxel: how far facets may be from the spheres and cones that they stand for.
constexpr double kFacetTolerance = 0.25;

struct Source {
    std::vector<std::byte> bytes;
    std::string name;
    ReadInner read;

    std::string_view text() const {
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
};

Source open(const MeshFile& file) {
    const std::filesystem::path& path = file.path;
    return {read_file_beneath(path, kMaxFileBytes), path.filename().string(),
            files_beneath(path.has_parent_path() ? path.parent_path() : ".")};
}

ObjParams obj_params(const MeshFile& file) {
    return {.materials = file.materials, .emission_scale = file.emission_scale, .limits = {}};
}

double longest_side(const Box& box) {
    const Vec3 size = box.high - box.low;
    return std::max({size.x, size.y, size.z});
}

TriangleMesh load_nff(const Source& source, const MeshFile& file) {
    const NffScene scene = parse_nff(source.text(), source.name);
    const double voxel = file.voxel_size_m
                             ? *file.voxel_size_m / file.unit_m
                             : longest_side(safe_boxes(scene.shapes).root) / *file.resolution;
    return nff_mesh(scene, {.tolerance = kFacetTolerance * voxel, .limits = {}}, source.name);
}

TriangleMesh load_as_it_stands(const Source& source, const MeshFile& file) {
    if (file.format == MeshFormat::kGltf) {
        return import_gltf(source.bytes, {.emission_scale = file.emission_scale, .limits = {}},
                           source.read, source.name);
    }
    if (file.format == MeshFormat::kNff) return load_nff(source, file);
    return import_obj(source.text(), obj_params(file), source.read, source.name);
}

Box bounds_of(const TriangleMesh& mesh) {
    Box bounds = empty_box();
    for (const MeshTriangle& triangle : mesh.triangles) {
        for (const uint32_t vertex : triangle.vertices) {
            bounds = join(bounds, mesh.positions[vertex]);
        }
    }
    return bounds;
}

}  // namespace

std::string_view name_of(MeshFormat format) {
    constexpr std::string_view kNames[] = {"gltf", "obj", "nff"};
    return kNames[static_cast<size_t>(format)];
}

MeshFile read_mesh_file(ObjectReader& scene, MeshFormat format,
                        const std::filesystem::path& folder) {
    MeshFile file;
    file.format = format;
    file.path = folder / read_file_name(scene, "file");
    const bool both = scene.has("voxel_size_m") && scene.has("resolution");
    if (both) {
        scene.issues().unacceptable(scene.pointer_to("resolution"),
                                    "expected either voxel_size_m or resolution");
    }
    if (scene.has("resolution")) {
        file.resolution = static_cast<int>(scene.integer("resolution", 1, kMaxMeshVoxels, 1));
    }
    if (!file.resolution || both) {
        file.voxel_size_m = scene.number("voxel_size_m", {1e-6, 1e3}, std::nullopt);
    }
    file.unit_m = scene.number("unit_m", {1e-6, 1e6}, file.unit_m);
    file.solid = scene.boolean("solid", file.solid);
    if (format != MeshFormat::kNff) {  // which emits nothing
        file.emission_scale = scene.number("emission_scale", {0.0, 1e9}, file.emission_scale);
    }
    if (format != MeshFormat::kGltf) {
        constexpr std::string_view kAxes[] = {"y", "z"};
        file.z_up = scene.choice("up", kAxes, 0) == 1;
        file.two_sided = scene.boolean("two_sided", file.two_sided);
    }
    if (format == MeshFormat::kObj && scene.has("materials")) {
        file.materials = read_file_name(scene, "materials");
    }
    return file;
}

TriangleMesh load_mesh(const MeshFile& file) {
    const Source source = open(file);
    TriangleMesh mesh = load_as_it_stands(source, file);
    if (mesh.triangles.empty()) throw IoError(source.name, "has no triangles");
    if (file.format != MeshFormat::kGltf) {  // whose materials say it themselves
        for (MeshMaterial& material : mesh.materials) material.double_sided = file.two_sided;
    }
    // Of glTF's axes and metres nothing changes, and no digit is lost.
    for (Vec3& p : mesh.positions) {
        if (file.z_up) p = Vec3(p.x, p.z, -p.y);
        p *= file.unit_m;
        if (!is_finite(p))
            throw IoError(source.name, "has positions that are not finite in metres");
    }
    return mesh;
}

double mesh_voxel_size_m(const MeshFile& file, const TriangleMesh& mesh) {
    const double side = longest_side(bounds_of(mesh));
    const double size = file.voxel_size_m ? *file.voxel_size_m : side / *file.resolution;
    const std::string name = file.path.filename().string();
    if (!(size >= 1e-6 && size <= 1e3)) {
        throw IoError(name, "its longest side of " + std::to_string(side) + " m gives voxels of " +
                                std::to_string(size) + " m, expected 1e-6 to 1e3");
    }
    if (!(side / size <= kMaxMeshVoxels)) {
        throw IoError(name, "its longest side of " + std::to_string(side) + " m has " +
                                std::to_string(side / size) + " voxels, expected at most " +
                                std::to_string(kMaxMeshVoxels));
    }
    return size;
}

void hash_mesh(const MeshFile& file, Sha256& sha) {
    const Source source = open(file);
    sha.update(source.bytes);
    std::vector<std::string> names;
    if (file.format == MeshFormat::kGltf) {
        GltfDocument document = check_gltf(source.bytes, source.name);
        names = std::move(document.buffers);
        std::move(document.images.begin(), document.images.end(), std::back_inserter(names));
    } else if (file.format == MeshFormat::kObj) {
        names = obj_references(source.text(), obj_params(file), source.read, source.name);
    }
    for (const std::string& name : names) {
        const auto bytes = read_inner(source.read, name, source.name);
        // Lengths keep files apart.
        sha.update(name + (bytes ? "\n" + std::to_string(bytes->size()) + "\n" : "\nmissing\n"));
        if (bytes) sha.update(*bytes);
    }
}

}  // namespace probebake
