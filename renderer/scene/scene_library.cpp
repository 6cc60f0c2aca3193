#include "scene/scene_library.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <system_error>
#include <utility>

#include "io/cache_folder.h"
#include "io/file_beneath.h"
#include "io/json.h"
#include "io/sha256.h"
#include "scene/heightmap/heightmap_import.h"
#include "scene/surface_file.h"
#include "scene/vox/vox_import.h"
#include "voxels/tree_file.h"

namespace probebake {
namespace {

using Clock = std::chrono::steady_clock;

/// Changes whenever an importer or generator makes other voxels of the same file.
constexpr std::string_view kImportVersion = "probebake voxels 1\n";
constexpr uint64_t kMaxSceneFileBytes = uint64_t{64} << 10;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

GeneratorParams read_generator(ObjectReader& reader) {
    GeneratorParams params;
    params.name = reader.name("generator", std::nullopt);
    params.size = static_cast<int>(reader.integer("size", 1, 65536, params.size));
    params.seed =
        reader.unsigned_integer("seed", std::numeric_limits<uint64_t>::max(), params.seed);
    return params;
}

HeightmapFiles read_heightmap(ObjectReader& reader, const std::filesystem::path& folder) {
    HeightmapFiles files;
    files.heights = folder / read_file_name(reader, "file");
    if (reader.has("color_file")) files.colors = folder / read_file_name(reader, "color_file");
    std::optional<double> scale;
    if (files.is_exr()) scale = 1.0;
    files.height_scale_m = reader.number("height_scale_m", {1e-6, 1e3}, scale);
    return files;
}

Terrain import_heightmap_files(const HeightmapFiles& files, double voxel_size_m) {
    const std::string name = files.heights.filename().string();
    const std::vector<std::byte> heights = read_file_beneath(files.heights);
    std::optional<ColorPicture> colors;
    if (files.colors) {
        colors =
            read_color_picture(read_file_beneath(*files.colors), files.colors->filename().string());
    }
    const HeightmapParams params{.height_scale_m = files.height_scale_m,
                                 .voxel_size_m = voxel_size_m};
    if (files.is_exr()) {
        return import_heightmap(read_height_exr(heights, name), colors, params, name);
    }
    return {import_heightmap(read_grey_png(heights, name), colors, params, name), IVec3(0)};
}

/// The voxels of a scene file, as a tree, and what else the cache must give back.
struct World {
    VoxelTree tree;
    Vec3 lowest{0.0};                    // where its corner lies in the file's own space, voxels
    std::optional<double> voxel_size_m;  // of meshes: the scene file need not say it
    std::optional<MeshWorld> mesh;
    SurfaceTriangles surface;
    std::vector<std::string> warnings;
};

/// The voxels of a mesh, of which nothing else is kept but where its triangles lie.
World make_mesh_world(const MeshFile& file) {
    World world;
    TriangleMesh mesh = load_mesh(file);
    const double size_m = mesh_voxel_size_m(file, mesh);
    world.voxel_size_m = size_m;
    world.warnings = std::move(mesh.warnings);
    try {
        VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = size_m, .solid = file.solid});
        world.tree = std::move(made.tree);
        world.surface = std::move(made.surface);
        world.lowest = made.corner_m / size_m;
        world.mesh = {made.report, mesh.materials.size(), mesh.textures.size(), mesh.suns};
    } catch (const std::invalid_argument& error) {
        throw IoError(file.path.filename().string(), error.what());
    }
    if (file.solid && world.mesh->voxels.filled_voxels == 0) {
        world.warnings.emplace_back(
            "nothing was filled: the surface closes nothing in, or has openings of a voxel or "
            "more");
    }
    if (world.mesh->voxels.uncovered_points > 0) {
        world.warnings.push_back(std::to_string(world.mesh->voxels.uncovered_points) +
                                 " points of the surface lie in no voxel");
    }
    return world;
}

World make_world(const SceneFile& file, SceneLoadStats& stats) {
    const auto start = Clock::now();
    if (file.mesh) {
        World made = make_mesh_world(*file.mesh);
        stats.import_seconds = seconds_since(start);
        return made;
    }
    World world;
    VoxelCloud cloud;
    if (file.generator) {
        cloud = generate(*file.generator);
    } else if (file.heightmap) {
        Terrain terrain = import_heightmap_files(*file.heightmap, file.voxel_size_m);
        cloud = std::move(terrain.cloud);
        world.lowest = terrain.lowest;
    } else {
        VoxImport import = import_vox(read_file_beneath(*file.vox), file.vox->filename().string());
        cloud = std::move(import.cloud);
        world.lowest = import.lowest;
        world.warnings = std::move(import.warnings);
    }
    stats.import_seconds = seconds_since(start);
    world.tree = VoxelTree::build(std::move(cloud), &stats.build);
    return world;
}

std::filesystem::path cached_surface(const std::filesystem::path& cache_dir,
                                     const std::string& sha256) {
    return cache_dir / (sha256 + ".surface");
}

void save_world(const std::filesystem::path& cache_dir, const std::string& sha256,
                const World& world) {
    Json notes = {{"lowest", {world.lowest.x, world.lowest.y, world.lowest.z}},
                  {"warnings", world.warnings}};
    if (world.voxel_size_m) notes["voxel_size_m"] = *world.voxel_size_m;
    if (world.mesh) notes["mesh"] = write_mesh_world(*world.mesh);
    std::filesystem::create_directories(cache_dir);
    if (world.mesh) save_surface(cached_surface(cache_dir, sha256), world.surface);
    save_tree(cached_tree(cache_dir, sha256), world.tree, dump_json(notes));
}

/// No value where the cache does not have all of it, whole.
std::optional<World> load_world(const std::filesystem::path& cache_dir, const std::string& sha256) {
    try {
        TreeFile file = load_tree(cached_tree(cache_dir, sha256));
        const Json notes = parse_json(file.notes);
        World world{.tree = std::move(file.tree)};
        for (int axis = 0; axis < 3; ++axis) {
            world.lowest[axis] = notes.at("lowest").at(static_cast<size_t>(axis)).get<double>();
        }
        if (notes.contains("voxel_size_m")) {
            world.voxel_size_m = notes["voxel_size_m"].get<double>();
        }
        if (notes.contains("mesh")) {
            world.mesh = read_mesh_world(notes["mesh"]);
            world.surface = load_surface(cached_surface(cache_dir, sha256));
        }
        world.warnings = notes.at("warnings").get<std::vector<std::string>>();
        return world;
    } catch (const IoError&) {
        return std::nullopt;
    }
}

/// All of a scene but its world.
Scene scene_of(const SceneFile& file) {
    Scene scene;
    scene.name = file.name;
    scene.sha256 = content_sha256(file);
    scene.author = file.author;
    scene.licence = file.licence;
    scene.voxel_size_m = file.voxel_size_m;
    scene.folder = file.folder;
    return scene;
}

void put_world(World world, const SceneFile& file, Media media, Scene& scene) {
    scene.tree = std::move(world.tree);
    scene.warnings = std::move(world.warnings);
    if (world.voxel_size_m) scene.voxel_size_m = *world.voxel_size_m;
    scene.mesh = std::move(world.mesh);
    scene.surface = std::move(world.surface);
    scene.solid_ground = file.heightmap.has_value();
    scene.corner_m = file.origin_m + world.lowest * scene.voxel_size_m;
    scene.media = std::move(media);
}

/// Of what is kept of a scene beside its tree.
std::filesystem::path cached_stem(const std::filesystem::path& cache_dir,
                                  const std::string& sha256) {
    return cache_dir / sha256;
}

}  // namespace

bool is_file_name(const std::string& text) {
    return !text.empty() && text.size() <= 64 && text[0] != '.' &&
           std::all_of(text.begin(), text.end(), [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      c == '.' || c == '_' || c == '-';
           });
}

std::string read_file_name(ObjectReader& reader, std::string_view key) {
    std::string name = reader.string(key, 64, std::nullopt);
    if (!is_file_name(name)) {
        reader.issues().unacceptable(reader.pointer_to(key),
                                     "expected the name of a file in the scene's own folder");
    }
    return name;
}

SceneFile read_scene_file(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = read_file_beneath(path, kMaxSceneFileBytes);
    SceneFile file;
    file.name = path.stem().string();
    file.folder = path.parent_path();
    file.text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const Json document = parse_json(file.text);
    JsonIssues issues;
    ObjectReader reader(document, "", issues);
    constexpr std::string_view kTypes[] = {"generator", "vox", "heightmap", "gltf", "obj", "nff"};
    const size_t type = reader.choice("type", kTypes, std::nullopt);
    file.description = reader.string("description", 1000, "");
    file.author = reader.string("author", 200, "");
    file.licence = reader.string("licence", 200, "");
    file.origin_m = reader.vector("origin_m", 1e6, Vec3(0.0));
    if (type == 0) {
        file.generator = read_generator(reader);
        try {
            const double size_m = voxel_size_m(*file.generator);
            file.voxel_size_m = reader.number("voxel_size_m", {1e-6, 1e3}, size_m);
        } catch (const std::invalid_argument& error) {
            issues.unacceptable(reader.pointer_to("generator"), error.what());
        }
    } else if (type >= 3) {
        constexpr MeshFormat kFormats[] = {MeshFormat::kGltf, MeshFormat::kObj, MeshFormat::kNff};
        file.mesh = read_mesh_file(reader, kFormats[type - 3], file.folder);
    } else {
        file.voxel_size_m = reader.number("voxel_size_m", {1e-6, 1e3}, std::nullopt);
        if (type == 1) {
            file.vox = path.parent_path() / read_file_name(reader, "file");
        } else {
            file.heightmap = read_heightmap(reader, path.parent_path());
        }
    }
    file.media = read_media(reader, file.folder);
    reader.refuse_unknown();
    issues.throw_if_any();
    return file;
}

std::string content_sha256(const SceneFile& file) {
    Sha256 sha;
    sha.update(kImportVersion);
    sha.update(file.text);
    if (file.vox) sha.update(read_file_beneath(*file.vox));
    if (file.heightmap) {
        sha.update(read_file_beneath(file.heightmap->heights));
        if (file.heightmap->colors) sha.update(read_file_beneath(*file.heightmap->colors));
    }
    if (file.mesh) hash_mesh(*file.mesh, sha);
    for (const MediumFile& medium : file.media) {
        if (medium.vdb) sha.update(read_file_beneath(medium.vdb->path));
    }
    return sha.hex();
}

Scene load_scene(const SceneFile& file, const std::optional<std::filesystem::path>& cache_dir) {
    const auto start = Clock::now();
    if (cache_dir) {
        if (std::optional<Scene> scene = find_cached_scene(file, *cache_dir)) {
            scene->cache_dir = cache_dir;
            return *std::move(scene);
        }
    }
    Scene scene = scene_of(file);
    scene.cache_dir = cache_dir;
    World world = make_world(file, scene.load);
    std::optional<Media> media;
    try {
        if (cache_dir) {
            const std::filesystem::path stem = cached_stem(*cache_dir, scene.sha256);
            save_world(*cache_dir, scene.sha256, world);
            cache_grids(file.media, stem);
            media = load_media(file.media, stem);
        }
    } catch (const std::runtime_error& error) {  // costs time later, nothing else
        world.warnings.push_back(std::string("the scene cache was not written: ") + error.what());
    }
    if (!media) media = load_media(file.media);
    put_world(std::move(world), file, std::move(*media), scene);
    scene.load.total_seconds = seconds_since(start);
    return scene;
}

std::filesystem::path cached_tree(const std::filesystem::path& cache_dir,
                                  const std::string& sha256) {
    return cache_dir / (sha256 + ".voxtree");
}

std::optional<Scene> find_cached_scene(const SceneFile& file,
                                       const std::filesystem::path& cache_dir) {
    const auto start = Clock::now();
    Scene scene = scene_of(file);
    std::optional<World> world = load_world(cache_dir, scene.sha256);
    if (!world) return std::nullopt;
    try {
        put_world(std::move(*world), file,
                  load_media(file.media, cached_stem(cache_dir, scene.sha256)), scene);
    } catch (const IoError&) {  // a grid that is not there whole
        return std::nullopt;
    }
    mark_used(cached_tree(cache_dir, scene.sha256));
    if (scene.mesh) mark_used(cached_surface(cache_dir, scene.sha256));
    scene.load.from_cache = true;
    scene.load.total_seconds = seconds_since(start);
    return scene;
}

void import_scene(const SceneFile& file, const std::filesystem::path& cache_dir) {
    SceneLoadStats stats;
    const std::string sha256 = content_sha256(file);
    save_world(cache_dir, sha256, make_world(file, stats));
    cache_grids(file.media, cached_stem(cache_dir, sha256));
}

void remove_cached_scene(const SceneFile& file, const std::string& sha256,
                         const std::filesystem::path& cache_dir) {
    std::error_code error;
    std::filesystem::remove(cached_tree(cache_dir, sha256), error);
    std::filesystem::remove(cached_surface(cache_dir, sha256), error);
    remove_cached_grids(file.media, cached_stem(cache_dir, sha256));
}

bool is_foreign(const SceneFile& file) { return !file.generator || has_grid_files(file.media); }

SceneLibrary::SceneLibrary(std::filesystem::path folder,
                           std::optional<std::filesystem::path> uploads)
    : folder_(std::move(folder)), uploads_(std::move(uploads)) {
    names();
}

std::vector<std::string> SceneLibrary::names() const {
    std::set<std::string> found;
    const auto list = [&](const std::filesystem::path& folder, const auto& name_of) {
        std::error_code error;
        for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
             at.increment(error)) {
            std::string name = name_of(at->path());
            if (is_name(name)) found.insert(std::move(name));
        }
        if (error) throw IoError(folder.string(), "cannot be listed: " + error.message());
    };
    list(folder_, [](const std::filesystem::path& path) {
        return path.extension() == ".json" ? path.stem().string() : "";
    });
    if (uploads_) {
        list(*uploads_, [](const std::filesystem::path& path) { return path.filename().string(); });
    }
    return {found.begin(), found.end()};
}

bool SceneLibrary::owns(const std::string& name) const {
    std::error_code error;
    return is_name(name) && std::filesystem::is_regular_file(folder_ / (name + ".json"), error);
}

std::optional<SceneFile> SceneLibrary::find(const std::string& name) const {
    if (!is_name(name)) return std::nullopt;
    if (owns(name)) return read_scene_file(folder_ / (name + ".json"));
    if (!uploads_) return std::nullopt;
    const std::filesystem::path path = *uploads_ / name / (name + ".json");
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
    return read_scene_file(path);
}

}  // namespace probebake
