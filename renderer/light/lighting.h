// The lighting stage: between loading a scene and rendering it, once per lighting state.
//
//   light_scene(tree, Lighting) -> FaceColors: per exposed voxel face
//       L = albedo / π · (E_sun + E_sky) + emission        W·m⁻²·sr⁻¹, Lambert
//
// E_sun: shadow rays from stratified points of the face to stratified points of the disc.
// E_sky: stratified shadow rays (sky_light.h) from random points of all faces of one direction
//        within a node of `gather_level` that front the same air; these faces share the sum. Faces
//        between which no air leads through the node and the layer of voxels around it (a floor
//        and the ground outside, with a wall between them) never do: no light leaks.
//
// Light that one surface throws on another is no part of it: a further pass would add it to the
// FaceColors. Deterministic: every random stream is keyed by the seed and a voxel's place; the
// same bytes for any number of threads.
#pragma once

#include <optional>

#include "io/cancel.h"
#include "light/face_colors.h"
#include "light/shadow_ray.h"
#include "light/sky.h"

namespace probebake {

struct Sun {
    Vec3 direction{0.0, 1.0, 0.0};      // towards the sun, any length
    Rgb irradiance{0.0f};               // W·m⁻² on a surface that faces it
    double angular_diameter_deg = 0.0;  // 0: sharp shadows

    bool operator==(const Sun&) const = default;
};

struct Lighting {
    std::optional<Sun> sun;
    Sky sky;
    bool emission = true;  // whether emissive voxels are seen
};

struct LightingParams {
    int sun_rays = 4;      // per exposed face that is turned to the sun
    int sky_rays = 64;     // per gathering
    int gather_level = 0;  // octree level of the nodes that gather the sky, at most kMaxGatherLevel
    ShadowSettings shadow;
    uint64_t seed = 1;
};
inline constexpr int kMaxGatherLevel = 4;

/// The gather level whose nodes have about this edge.
int gather_level_for(double voxel_size_m, double edge_m = 1.0);

struct LightingCost {
    uint64_t faces = 0;       // exposed voxel faces
    uint64_t gatherings = 0;  // of the sky
    uint64_t sun_rays = 0;
    uint64_t sky_rays = 0;
    uint64_t steps = 0;    // of all shadow rays, as CostStats counts them
    double seconds = 0.0;  // summed over threads
    double wall_seconds = 0.0;
    uint64_t memory_bytes = 0;  // of the FaceColors
    bool from_cache = false;    // not spent now, but the seconds to read it

    LightingCost& operator+=(const LightingCost& other);
};

struct LitScene {
    FaceColors colors;
    LightingCost cost;
};

/// Runs on the calling arena. Throws Cancelled; std::length_error beyond 2^32 − 1 exposed faces;
/// std::invalid_argument for parameters or light that are negative, not finite or out of range.
LitScene light_scene(const VoxelTree& tree, const Lighting& lighting, const LightingParams& params,
                     const CancelToken& cancel);

}  // namespace probebake
