// A probe in one lighting state as it is rendered now: what is audited and written into files.
#pragma once

#include "bake/pilot.h"
#include "bake/render_noise.h"
#include "image/cubemap.h"
#include "render/render.h"
#include "scatter/volume_cubemap.h"

namespace probebake {

/// All that is referred to outlives it.
struct RenderedProbe {
    const Scene& scene;
    const JobSpec& job;
    const Pilot& pilot;
    size_t probe = 0;  // index into JobSpec::probes
    const RenderScene& render_scene;
    const CubemapRender& render;
    const Cubemap& as_written;  // rounded as the files round
    const RenderSettings& settings;
    double mse = 0.0;  // that the pilot found of these settings

    const ProbeSpec& spec() const { return job.probes[probe]; }
    bool through_media() const { return pilot.media != nullptr; }
    bool leaf_rays_only() const { return wants_leaf_rays_only(job) && !through_media(); }
    /// Whether what variances lead to expect of its irradiance is asked.
    bool irradiance_by_noise() const;
    RenderNoise noise() const;
    /// Of the paths that render it.
    VolumeView paths_view() const;
};

}  // namespace probebake
