// A probe as the renderers see it: its scene in voxels, its faces, its random streams.
#pragma once

#include <numbers>
#include <vector>

#include "bake/state_light.h"
#include "render/pixel.h"

namespace probebake {

/// Distance in metres beyond which the probe sees nothing: its far_m, or the end of the world.
inline double effective_far_m(const Scene& scene, const ProbeSpec& probe) {
    return probe.far_m.value_or(scene.reach_m(probe.position_m));
}

/// The value per voxel and node that a state shows; where it is lit per face, the albedo, by which
/// renderers judge how much colours vary.
inline const ColorLevels& colors_of(const Scene& scene, const ReadyState& state) {
    if (state.spec.kind == LightingState::Kind::kEmission) return scene.tree.colors().emission;
    if (state.light != nullptr && !state.light->voxel_values.empty()) {
        return state.light->voxel_values;
    }
    return scene.tree.colors().albedo;
}

/// What the probe sees in a lighting state. Scene and state outlive it.
inline RenderScene render_scene(const Scene& scene, const ProbeSpec& probe,
                                const ReadyState& state) {
    const StateLight* light = state.light.get();
    const bool per_voxel = light != nullptr && !light->voxel_values.empty();
    return {.tree = scene.tree,
            .color = colors_of(scene, state),
            .range = {.t_min = probe.near_m / scene.voxel_size_m,
                      .t_max = effective_far_m(scene, probe) / scene.voxel_size_m},
            .lit = light != nullptr && !per_voxel ? &light->colors : nullptr,
            .sky = light != nullptr ? &light->sky : nullptr};
}

inline View face_view(const Scene& scene, const ProbeSpec& probe, CubeFace face) {
    return cube_face_view(face, probe.face_size_px, scene.to_voxels(probe.position_m));
}

/// What the error of a stored pixel counts for in the mean over a cubemap; 1 on average.
inline double pixel_weight(Weighting weighting, const CubePixel& pixel, int n) {
    if (weighting == Weighting::kUniform) return 1.0;
    const double mean = 4.0 * std::numbers::pi / (6.0 * n * n);
    return pixel_solid_angle(pixel.x, pixel.y, n) / mean;
}

/// By which squared errors of owned pixels (radiance²) add up to a cubemap's mean squared error, in
/// the order of its image; 0 for pixels that another face owns.
std::vector<double> owned_pixel_weights(Weighting weighting, int n, double exposure);

/// What a random stream is for: streams of different purposes share no number.
enum class StreamPurpose : uint64_t {
    kPilotChoice = 1,
    kPilotTruth = 2,
    kAuditChoice = 3,
    kAuditTruth = 4,
    kLighting = 5,
    kMediaPilot = 6,
    kMediaRender = 7,
};

}  // namespace probebake
