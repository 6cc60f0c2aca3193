// A lighting state seen through media: what its paths run through, and the tracker that they use.
//
// A scene with media shows them in every state but `albedo`, which is reflectance: their pixels are
// means of volumetric paths (scatter/path_tracer.h), whose number goes where the variance is. Sun,
// sky and emissive voxels are met by the paths themselves: no light is computed per face. Rays go
// to emissive voxels where the pilot finds variance × cost smaller with them.
#pragma once

#include <memory>
#include <vector>

#include "bake/quality.h"
#include "bake/state_light.h"
#include "render/render.h"
#include "scatter/tracker_pilot.h"
#include "scatter/volume_cubemap.h"

namespace probebake {

/// No render takes more paths in a pixel, whatever its target.
inline constexpr int kMostPathsPerPixel = 1 << 16;

/// Whether the state's pixels are paths through media.
bool sees_media(const Scene& scene, const LightingState& state);

/// What the plan says of them: the tracker by the rule, and what the rule left out.
struct MediaPlan {
    TrackerChoice choice;
    std::vector<std::string> media;  // "name: shape, …"
    std::string emitters;            // how emissive voxels are met; empty where none is to be
    uint64_t bytes = 0;              // of grids and octrees
};
/// Throws SpecError (unacceptable) where the job forces a tracker that cannot render these media,
/// or asks for what paths cannot give. The scene has media.
MediaPlan plan_media(const Scene& scene, const JobSpec& job);

/// The state, with tracker and octrees as its pilot found them best. Neither copied nor moved: its
/// parts refer to each other.
struct MediaState {
    MediaState(const Scene& scene, const ReadyState& state, const JobSpec& job,
               const PilotRay& ray);
    MediaState(const MediaState&) = delete;
    MediaState& operator=(const MediaState&) = delete;

    Lighting lighting;
    DepthPilot depth;  // empty where no medium is a grid
    Media own_media;   // with octrees of that depth; empty where the scene's own are as good
    TrackerPilot tracker_pilot;
    /// Kept where rays to emissive voxels pay; the pilot, wherever it was asked.
    std::optional<EmitterSampler> emitters;
    std::optional<EmitterPilot> emitter_pilot;
    std::optional<PathTracer> tracer;

    const Media& media(const Scene& scene) const {
        return own_media.empty() ? scene.media : own_media;
    }
};

/// Distance in metres beyond which first rays see nothing but the sky: the probe's far_m, or the
/// end of voxels and media.
double effective_far_through_media_m(const Scene& scene, const ProbeSpec& probe);

/// The probe as paths see it.
VolumeView volume_view(const Scene& scene, const ProbeSpec& probe, uint64_t key);

/// What a render through media may take in all, beyond the fewest paths in every pixel.
struct PathLimits {
    std::optional<uint64_t> paths;
    std::optional<double> seconds;  // of all threads together
};

/// A whole cubemap. Of the settings, `samples` and `noise` count.
CubemapRender render_through_media(const Scene& scene, const PathTracer& tracer,
                                   const VolumeView& view, const RenderSettings& settings,
                                   const PathLimits& limits, const CancelToken& cancel);

/// Two independent means of `paths` paths each.
TruthPair path_truth(const PathTracer& tracer, const VolumeView& view, const CubePixel& owner,
                     int paths, uint64_t key, CostStats& stats);

/// The same figures in the counters of all renderers.
CostStats cost_of(const PathCount& count);

}  // namespace probebake
