// probebake scene info FILE_OR_SCENE: what a scene is and what it takes to load; scene probes:
// positions to begin with.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "bake/report.h"
#include "commands/commands.h"
#include "commands/local_job.h"
#include "commands/terminal.h"
#include "engine/render_pool.h"
#include "scene/suggest_probes.h"

namespace probebake {
namespace {

struct SceneInfoOptions {
    std::string scene;
    SceneOptions scenes;
    bool json = false;
    int count = 8;
    uint64_t seed = 1;
};

/// A .vox file has no voxel size of its own: its figures are shown for voxels of one metre.
SceneFile find_scene_or_vox(const SceneInfoOptions& options) {
    const std::filesystem::path path = options.scene;
    if (path.extension() != ".vox") return find_scene(options.scenes, options.scene);
    SceneFile file;
    file.name = path.stem().string();
    file.vox = path;
    return file;
}

/// Lowest corner and size of the box that holds all voxels.
struct Bounds {
    IVec3 lowest{0};
    IVec3 extent{0};
};

Bounds bounds_of(const VoxelTree& tree) {
    IVec3 lowest(1 << kMaxDepth);
    IVec3 highest(-1);
    tree.for_each_voxel([&](const IVec3& position) {
        lowest = glm::min(lowest, position);
        highest = glm::max(highest, position);
    });
    if (tree.empty()) return {};
    return {lowest, highest - lowest + IVec3(1)};
}

uint64_t emissive_voxels(const VoxelTree& tree) {
    const std::vector<PackedRgb>& emission = tree.colors().emission.voxels;
    return static_cast<uint64_t>(
        std::count_if(emission.begin(), emission.end(), [](PackedRgb e) { return e != 0; }));
}

Json describe(const Scene& scene) {
    const VoxelTree& tree = scene.tree;
    const Bounds bounds = bounds_of(tree);
    const Vec3 lowest_m = scene.to_metres(Vec3(bounds.lowest));
    const Vec3 extent_m = Vec3(bounds.extent) * scene.voxel_size_m;
    Json info = write_scene(scene);
    info["emissive_voxels"] = emissive_voxels(tree);
    info["octree_nodes_per_level"] = tree.octree_nodes_per_level();
    info["extent_voxels"] = {bounds.extent.x, bounds.extent.y, bounds.extent.z};
    info["lowest_m"] = {lowest_m.x, lowest_m.y, lowest_m.z};
    info["extent_m"] = {extent_m.x, extent_m.y, extent_m.z};
    info["node_bytes"] = tree.node_bytes();
    info["duplicates"] = scene.load.build.duplicates;
    info["warnings"] = scene.warnings;
    return info;
}

std::string triple(const Json& values, int decimals) {
    return fixed(values[0], decimals) + " x " + fixed(values[1], decimals) + " x " +
           fixed(values[2], decimals);
}

void print(const Json& info) {
    const auto voxels = info["voxels"].get<uint64_t>();
    const auto nodes = info["octree_nodes"].get<uint64_t>();
    std::cout << info["name"].get<std::string>() << ": " << grouped(voxels) << " voxels of "
              << info["voxel_size_m"].dump() << " m, " << grouped(info["emissive_voxels"])
              << " emissive\n"
              << "extent " << triple(info["extent_voxels"], 0) << " voxels, "
              << triple(info["extent_m"], 2) << " m\n"
              << grouped(nodes) << " octree nodes, "
              << fixed(voxels > 0 ? static_cast<double>(nodes) / static_cast<double>(voxels) : 0.0,
                       3)
              << " per voxel, " << info["depth"].get<int>() << " levels below the root\n"
              << "nodes " << bytes_text(info["node_bytes"]) << ", with colours "
              << bytes_text(info["bytes"]) << "\n";
    const Json& load = info["load"];
    std::cout << "loaded in " << fixed(load["seconds"], 2) << " s"
              << (load["from_cache"].get<bool>()
                      ? " from the cache"
                      : " (import " + fixed(load["import_seconds"], 2) + ", sort " +
                            fixed(load["sort_seconds"], 2) + ", tree " +
                            fixed(load["tree_seconds"], 2) + ", colours " +
                            fixed(load["color_seconds"], 2) + "), build peak " +
                            bytes_text(load["build_peak_bytes"]))
              << "\nsha256 " << info["sha256"].get<std::string>() << '\n';
    for (const Json& warning : info["warnings"]) {
        std::cout << "warning: " << warning.get<std::string>() << '\n';
    }
}

int scene_info(const SceneInfoOptions& options) {
    const SceneFile file = find_scene_or_vox(options);
    RenderPool pool(options.scenes.threads);
    Json info;
    pool.run([&] { info = describe(load_scene(file, options.scenes.cache)); });
    if (options.json) {
        std::cout << dump_json(info, 2) << '\n';
    } else {
        print(info);
    }
    return 0;
}

/// A job's `probes`, ready to be pasted into a request.
int scene_probes(const SceneInfoOptions& options) {
    const SceneFile file = find_scene_or_vox(options);
    RenderPool pool(options.scenes.threads);
    Json probes = {{"list", Json::array()}};
    pool.run([&] {
        const Scene scene = load_scene(file, options.scenes.cache);
        for (const Vec3& p : suggest_probes(scene, options.count, options.seed)) {
            const std::string id = "p" + std::to_string(probes["list"].size());
            const auto centimetres = [](double x) { return std::round(100.0 * x) / 100.0; };
            probes["list"].push_back(
                {{"id", id},
                 {"position_m", {centimetres(p.x), centimetres(p.y), centimetres(p.z)}}});
        }
    });
    std::cout << dump_json(probes, 2) << '\n';
    return 0;
}

}  // namespace

void add_scene_command(CLI::App& app, CommandWork& work) {
    auto* scene = app.add_subcommand("scene", "Look at scenes");
    scene->require_subcommand(1);
    auto* info = scene->add_subcommand("info", "Load a scene and describe it");
    const auto options = std::make_shared<SceneInfoOptions>();
    info->add_option("scene", options->scene,
                     "Name in the scene folder, path of a scene file, or a .vox file")
        ->required();
    info->add_flag("--json", options->json, "Print the description as JSON");
    options->scenes.add_to(*info);
    info->callback([options, &work] { work = [options] { return scene_info(*options); }; });

    auto* probes = scene->add_subcommand(
        "probes", "Suggest probe positions in free air, as JSON for a request");
    probes->add_option("scene", options->scene, "As for scene info")->required();
    probes->add_option("--count", options->count, "How many at most")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    probes->add_option("--seed", options->seed, "Of their choice")->capture_default_str();
    options->scenes.add_to(*probes);
    probes->callback([options, &work] { work = [options] { return scene_probes(*options); }; });
}

}  // namespace probebake
