#include "bake/rendered_probe.h"

#include <algorithm>

#include "bake/learn.h"
#include "bake/probe_view.h"

namespace probebake {

bool RenderedProbe::pooled() const {
    const auto& steering = pilot.steering;
    return learns(job) && !steering.empty() &&
           std::all_of(steering.begin(), steering.end(),
                       [](const auto& target) { return target.has_value(); });
}

VolumeView RenderedProbe::paths_view() const {
    return volume_view(scene, spec(),
                       random_key({job.seed, static_cast<uint64_t>(StreamPurpose::kMediaRender),
                                   probe, stream_of(pilot.state.spec)}));
}

}  // namespace probebake
