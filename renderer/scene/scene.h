// A Scene: the voxel world that probes are baked in, and where it stands in metres.
//
// Immutable once loaded; jobs share it as `const Scene&`. World space is right-handed, +Y up, in
// metres; the tree's space is voxels of edge 1. Corner (0, 0, 0) of the tree is at `corner_m`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "math/vec.h"
#include "scene/mesh_world.h"
#include "volume/media.h"
#include "voxels/voxel_tree.h"

namespace probebake {

/// What loading a scene took.
struct SceneLoadStats {
    double import_seconds = 0.0;  // reading and placing, or generating
    BuildStats build;             // zero where the tree came from the cache
    double total_seconds = 0.0;
    bool from_cache = false;
};

struct Scene {
    std::string name;
    /// SHA-256 of the scene file and of everything it refers to: the same hash, the same voxels.
    std::string sha256;
    std::string author;  // for pictures of scenes that need one named
    std::string licence;
    VoxelTree tree;
    std::optional<MeshWorld> mesh;  // where it was made of one
    SurfaceTriangles surface;       // the same; in grid units (mesh/grid_mesh.h)
    bool solid_ground = false;      // a heightmap: all below the surface is ground
    Media media;                    // in metres; octrees of the default depth
    double voxel_size_m = 1.0;
    Vec3 corner_m{0.0};
    std::filesystem::path folder;  // of the scene file and of pictures of skies
    /// Where what is made of it may be kept between runs: trees, grids, light.
    std::optional<std::filesystem::path> cache_dir;
    std::vector<std::string> warnings;  // of the importer
    SceneLoadStats load;

    Vec3 to_voxels(const Vec3& position_m) const { return (position_m - corner_m) / voxel_size_m; }
    Vec3 to_metres(const Vec3& position) const { return position * voxel_size_m + corner_m; }
    uint64_t memory_bytes() const {
        return tree.memory_bytes() + media.memory_bytes() + surface.memory_bytes();
    }
    bool emits() const { return !tree.colors().emission.empty(); }

    /// Distance in metres beyond which no ray from this point can meet a voxel.
    double reach_m(const Vec3& position_m) const;
    /// Whether the point lies in a voxel.
    bool inside_voxel(const Vec3& position_m) const;
};

}  // namespace probebake
