#include "bake/rendered_probe.h"

#include "bake/audit_size.h"
#include "bake/probe_view.h"

namespace probebake {

bool RenderedProbe::irradiance_by_noise() const {
    return has_target(job.quality, QualityTarget::Metric::kIrradianceRel) &&
           (through_media() || irradiance_is_pooled(job, spec().face_size_px));
}

RenderNoise RenderedProbe::noise() const {
    return {render, as_written, pilot, through_media() ? std::nullopt : std::optional(mse)};
}

VolumeView RenderedProbe::paths_view() const {
    return volume_view(scene, spec(),
                       random_key({job.seed, static_cast<uint64_t>(StreamPurpose::kMediaRender),
                                   probe, stream_of(pilot.state.spec)}));
}

}  // namespace probebake
