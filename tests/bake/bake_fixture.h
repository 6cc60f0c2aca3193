// A small scene and jobs in it.
#pragma once

#include <string>
#include <utility>

#include "bake/job_spec.h"
#include "render/render_fixture.h"
#include "scene/scene.h"

namespace probebake::test {

/// The world of render_fixture.h at 25 cm per voxel, its origin off the world's.
inline Scene small_scene() {
    Scene scene;
    scene.name = "small";
    scene.sha256 = std::string(64, '5');
    scene.tree = small_world();
    scene.voxel_size_m = 0.25;
    scene.corner_m = {-8.0, 1.0, 2.0};
    return scene;
}

/// Some probes in free air, as a JSON request with the given quality.
inline Json small_request(int probes = 2, const Json& targets = {{"psnr_db", 32.0}}) {
    const Scene scene = small_scene();
    Json request = {{"scene", "small"}, {"face_size_px", 16}, {"seed", 7}};
    request["quality"]["targets"] = targets;
    for (int i = 0; i < probes; ++i) {
        const Vec3 p = scene.to_metres(kSmallWorldProbe + Vec3(3.1 * i, 0.4 * i, -2.3 * i));
        request["probes"]["list"].push_back(
            {{"id", "p" + std::to_string(i)}, {"position_m", {p.x, p.y, p.z}}});
    }
    return request;
}

inline JobSpec small_job(int probes = 2, const Json& targets = {{"psnr_db", 32.0}}) {
    return read_job(small_request(probes, targets));
}

}  // namespace probebake::test
