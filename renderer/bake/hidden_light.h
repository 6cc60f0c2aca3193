// Bright things that a cubemap's own rays may all have missed, looked for where they must be.
//
// A lamp or the brightest part of a sky's picture may show through a gap much smaller than a pixel
// and still carry more light than the rest of the cubemap. Neither the renderer's prediction nor a
// pixel drawn at random tells of it. But it is known where such things are: rays towards emissive
// voxels (EmitterSampler), and towards directions of the picture drawn by how much they would
// change their pixel, show which of them are seen. Audits draw pixels by what was found, too: that
// changes how well they see, and not what they mean (audit.h).
#pragma once

#include <vector>

#include "bake/state_light.h"
#include "image/cubemap.h"
#include "render/pixel.h"
#include "scatter/emitter_sampler.h"

namespace probebake {

/// Emissive voxels, where a state shows nothing else; none elsewhere. In lit states they cost more
/// than they tell (docs/decisions.md).
std::shared_ptr<const EmitterSampler> emitters_to_look_for(const Scene& scene,
                                                           const LightingState& state);

/// Whether there is anything of the kind in a scene.
bool may_hide_light(const RenderScene& scene, const EmitterSampler* emitters);

struct HiddenLightSpec {
    const RenderScene& scene;
    const EmitterSampler* emitters = nullptr;  // none: not looked for
    Vec3 origin{0.0};                          // voxels
    const Cubemap& as_written;
    int rays = 0;          // towards the sky
    int emitter_rays = 0;  // towards emissive voxels, drawn by what they may bring: few find them
    uint64_t key = 0;
};

/// For every stored pixel the mean squared difference, over its footprint and the channels, between
/// what directed rays saw in it and what the file says; empty where there is nothing to look for.
std::vector<double> hidden_light(const HiddenLightSpec& spec, CostStats& cost);

}  // namespace probebake
