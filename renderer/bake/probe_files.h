// The files of a probe: every product that the job names, with what is known of it in the headers.
#pragma once

#include "bake/probe_result.h"
#include "bake/rendered_probe.h"

namespace probebake {

/// Adds files, is_float and the tile of a grid's atlases to the result of an audited probe.
void make_files(const RenderedProbe& what, ProbeResult& result);

/// What the headers of all files of a job's state say: owner, state, scene, sky, seed, unit.
ProbeAttributes state_attributes(const Scene& scene, const JobSpec& job, const ReadyState& state);

}  // namespace probebake
