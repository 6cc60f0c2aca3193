// Scenes by name: a folder of scene files, and how a scene is made of one.
//
// A scene file NAME.json holds one object:
//
//   type          "generator", "vox", "heightmap", "gltf", "obj" or "nff"
//   generator     a name of generators(); size (voxels per side), seed
//   vox           file: a .vox file in the same folder; voxel_size_m (required, > 0)
//   heightmap     file: a 16-bit grey PNG in the same folder, or an EXR of one channel;
//                 color_file: a PNG or JPEG there, of the same size; height_scale_m per count
//                 (required; of an EXR: default 1) and voxel_size_m (required), both > 0
//   gltf,obj,nff  file: a mesh in the same folder; voxel_size_m or resolution; unit_m;
//                 emission_scale (gltf, obj); up (obj, nff); materials (obj); see mesh_file.h
//   all           media: what fills the air (media_file.h), default none
//                 origin_m: where the world's own origin lies, default [0, 0, 0]
//                 author, licence, description: texts, optional
//
// Names of scenes and files match [a-z0-9][a-z0-9._-]{0,63} (files also upper case); nothing a
// client sends is ever a path. docs/scenes.md has the details.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene/generators/generators.h"
#include "scene/media_file.h"
#include "scene/mesh_file.h"
#include "scene/scene.h"

namespace probebake {

/// The files of a heightmap scene.
struct HeightmapFiles {
    std::filesystem::path heights;
    std::optional<std::filesystem::path> colors;
    double height_scale_m = 1.0;  // per count or unit

    bool is_exr() const { return heights.extension() == ".exr"; }
};

/// A scene file, read and checked but not loaded.
struct SceneFile {
    std::string name;
    std::string description;
    std::string author;
    std::string licence;
    Vec3 origin_m{0.0};
    double voxel_size_m = 1.0;  // not of meshes: mesh_voxel_size_m says it
    /// Exactly one of these.
    std::optional<GeneratorParams> generator;
    std::optional<std::filesystem::path> vox;
    std::optional<HeightmapFiles> heightmap;
    std::optional<MeshFile> mesh;
    std::vector<MediumFile> media;
    /// Where the files lie that it names, and pictures of skies.
    std::filesystem::path folder;
    /// Content of the scene file, for the hash.
    std::string text;
};

/// A plain file name: no folder, nothing hidden, at most 64 characters.
bool is_file_name(const std::string& text);
/// Reads a required field that holds one; anything else is an issue.
std::string read_file_name(ObjectReader& reader, std::string_view key);

/// Reads a scene file; file names in it are taken from its folder. Throws IoError or SpecError.
SceneFile read_scene_file(const std::filesystem::path& path);

/// SHA-256 over the scene file and the files it refers to, without loading it. Throws IoError.
std::string content_sha256(const SceneFile& file);

/// Loads or generates a scene. With `cache_dir`, its tree is kept there under the content hash and
/// taken from there the next time; a damaged cache file is made anew. Parallel on the calling
/// arena. Throws IoError or SpecError.
Scene load_scene(const SceneFile& file,
                 const std::optional<std::filesystem::path>& cache_dir = std::nullopt);

/// Where the cache has a scene's tree.
std::filesystem::path cached_tree(const std::filesystem::path& cache_dir,
                                  const std::string& sha256);
/// No value where the cache does not have it whole. Throws IoError for files that cannot be read.
std::optional<Scene> find_cached_scene(const SceneFile& file,
                                       const std::filesystem::path& cache_dir);
/// Makes the scene's tree, decodes its grids and puts them into the cache. Throws as load_scene,
/// and where the cache cannot be written.
void import_scene(const SceneFile& file, const std::filesystem::path& cache_dir);
/// Takes what import_scene made out of the cache again.
void remove_cached_scene(const SceneFile& file, const std::string& sha256,
                         const std::filesystem::path& cache_dir);
/// Whether files of other programs are read for it.
bool is_foreign(const SceneFile& file);

class SceneLibrary {
  public:
    /// `uploads` holds further scenes, NAME/NAME.json each with its files beside it; of two of a
    /// name the folder's own counts. Throws IoError where a folder cannot be listed.
    explicit SceneLibrary(std::filesystem::path folder,
                          std::optional<std::filesystem::path> uploads = std::nullopt);

    /// Names of the scene files that are there now, sorted.
    std::vector<std::string> names() const;
    /// No value where there is no scene of that name. Throws IoError or SpecError for a bad file.
    std::optional<SceneFile> find(const std::string& name) const;
    /// Whether the folder itself has it.
    bool owns(const std::string& name) const;

  private:
    std::filesystem::path folder_;
    std::optional<std::filesystem::path> uploads_;
};

}  // namespace probebake
