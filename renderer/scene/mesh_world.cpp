#include "scene/mesh_world.h"

#include <cmath>
#include <limits>

namespace probebake {

Json write_mesh_world(const MeshWorld& world) {
    const VoxeliseReport& v = world.voxels;
    Json suns = Json::array();
    for (const MeshSun& sun : world.suns) {
        // As in a lighting state: towards the sun.
        suns.push_back(
            {{"direction", {-sun.direction.x, -sun.direction.y, -sun.direction.z}},
             {"irradiance_w_m2", {sun.irradiance.r, sun.irradiance.g, sun.irradiance.b}}});
    }
    return {{"triangles", v.triangles},
            {"materials", world.materials},
            {"textures", world.textures},
            {"voxels", v.voxels},
            {"filled_voxels", v.filled_voxels},
            {"seconds", v.seconds},
            {"peak_bytes", v.peak_bytes},
            {"checked_points", v.checked_points},
            {"uncovered_points", v.uncovered_points},
            {"hausdorff_m", std::isfinite(v.hausdorff_m) ? Json(v.hausdorff_m) : Json()},
            {"voxel_diagonal_m", v.voxel_diagonal_m},
            {"suns", std::move(suns)}};
}

MeshWorld read_mesh_world(const Json& json) {
    MeshWorld world;
    VoxeliseReport& v = world.voxels;
    v.triangles = json.at("triangles");
    world.materials = json.at("materials");
    world.textures = json.at("textures");
    v.voxels = json.at("voxels");
    v.filled_voxels = json.at("filled_voxels");
    v.seconds = json.at("seconds");
    v.peak_bytes = json.at("peak_bytes");
    v.checked_points = json.at("checked_points");
    v.uncovered_points = json.at("uncovered_points");
    const Json& distance = json.at("hausdorff_m");
    v.hausdorff_m =
        distance.is_null() ? std::numeric_limits<double>::infinity() : distance.get<double>();
    v.voxel_diagonal_m = json.at("voxel_diagonal_m");
    for (const Json& sun : json.at("suns")) {
        MeshSun out;
        for (int i = 0; i < 3; ++i) {
            const auto at = static_cast<size_t>(i);
            out.direction[i] = -sun.at("direction").at(at).get<double>();
            out.irradiance[i] = sun.at("irradiance_w_m2").at(at).get<float>();
        }
        world.suns.push_back(out);
    }
    return world;
}

}  // namespace probebake
