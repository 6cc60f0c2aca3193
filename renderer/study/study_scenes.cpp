#include "study/study_scenes.h"

#include <cmath>

#include "io/json.h"
#include "scene/generators/cornell.h"
#include "voxels/filled_box.h"

namespace probebake::study {
namespace {

StudyScene generated(const std::string& name, SceneKind kind, int size) {
    StudyScene scene{.name = name, .kind = kind};
    scene.file.name = name;
    scene.file.generator = GeneratorParams{.name = name, .size = size};
    scene.file.voxel_size_m = voxel_size_m(*scene.file.generator);
    scene.file.text = dump_json({{"type", "generator"}, {"generator", name}, {"size", size}});
    return scene;
}

StudyScene real(const std::string& name) {
    StudyScene scene{.name = name, .kind = SceneKind::kWorld};
    scene.file.name = name;
    scene.file.voxel_size_m = 0.25;
    scene.file.text = dump_json({{"name", name}, {"voxel_size_m", 0.25}});
    return scene;
}

/// The path of a data file, which `scene` is missing without.
std::filesystem::path need(StudyScene& scene, const std::optional<std::filesystem::path>& folder,
                           const std::string& file) {
    std::filesystem::path path = folder ? *folder / file : std::filesystem::path(file);
    std::error_code error;
    if (!folder || !std::filesystem::is_regular_file(path, error)) scene.missing = file;
    return path;
}

}  // namespace

std::vector<StudyScene> study_scenes(int size,
                                     const std::optional<std::filesystem::path>& data_folder) {
    std::vector<StudyScene> scenes;
    for (const char* name : {"desert", "forest", "mountain", "biomes"}) {
        scenes.push_back(generated(name, SceneKind::kTerrain, size));
    }
    StudyScene world = real("worldA");
    world.file.vox = need(world, data_folder, "vox/worldA_2048.vox");
    world.file.author = "maps by OvercastCommunity";
    world.file.licence = "CC BY-SA 4.0";
    scenes.push_back(std::move(world));
    StudyScene lidar = real("lidar");
    lidar.file.heightmap =
        HeightmapFiles{need(lidar, data_folder, "terrain/autzen_2048_dsm_u16.png"),
                       need(lidar, data_folder, "terrain/autzen_2048_rgb.jpg"), 1.0 / 256.0};
    lidar.file.author = "PDAL, autzen_trim.las";
    lidar.file.licence = "BSD";
    scenes.push_back(std::move(lidar));
    for (const char* name : {"grating", "net", "canopy", "slackline"}) {
        scenes.push_back(generated(name, SceneKind::kStructure, size));
    }
    scenes.push_back(generated("torch", SceneKind::kQuestion, size));
    // Its box and its beam are the same at every size.
    scenes.push_back(generated("cornell", SceneKind::kQuestion, cornell::kMinWorld));
    return scenes;
}

View view_down_on(const Vec3& target, double footprint, int view_px) {
    // At 90 degrees the view is twice as wide as it is high above the target.
    const double height = 0.5 * footprint * view_px;
    return perspective_view(
        {.origin = target + Vec3(0.0, height, 0.0), .width_px = view_px, .height_px = view_px});
}

View study_view(const Scene& scene, int size, std::optional<int> view_px) {
    const auto [low, high] = filled_box(scene.tree);
    constexpr int kSamples = 64;
    const Vec3 middle = 0.5 * (low + high);
    double sum = 0.0;
    int hits = 0;
    for (int j = 0; j < kSamples; ++j) {
        for (int i = 0; i < kSamples; ++i) {
            const Vec2 at = Vec2(i + 0.5, j + 0.5) / double{kSamples} - 0.5;
            const Vec3 origin(middle.x + at.x * size, high.y + 1.0, middle.z + at.y * size);
            const Hit hit = trace(scene.tree, {origin, Vec3(0.0, -1.0, 0.0)});
            if (!hit) continue;
            sum += origin.y - hit.t;
            ++hits;
        }
    }
    const double ground = hits > 0 ? sum / hits : low.y;
    const Vec3 off_grid(0.3711, 0.2303, 0.6127);
    const Vec3 target = Vec3(std::floor(middle.x), std::floor(ground), std::floor(middle.z));
    const int full_px = size / 4;
    View view = view_down_on(target + off_grid, 4.0, full_px);
    if (!view_px) return view;
    return perspective_view({.origin = view.origin, .width_px = *view_px, .height_px = *view_px});
}

RenderScene albedo_of(const Scene& scene) {
    return {.tree = scene.tree, .color = scene.tree.colors().albedo};
}

}  // namespace probebake::study
