// The places of a job's probes: looked at before anything is planned, and probes in bad ones moved
// where the job asks for it.
//
// Every job is told about its probes by the voxel tree alone, microseconds each. The triangles of a
// mesh are asked only where the request has `validity`: their object octree is made, used and
// dropped here.
#pragma once

#include "bake/job_spec.h"
#include "io/cancel.h"
#include "scene/scene.h"

namespace probebake {

/// What looking took, for the report.
struct PlacesRecord {
    uint64_t triangles = 0;  // in the octree; 0 where none was made
    uint64_t octree_bytes = 0;
    double seconds = 0.0;
};

/// Fills the places of all probes and moves those that `job.validity` has moved. The result depends
/// on scene and job alone. Parallel on the calling arena. Throws Cancelled.
PlacesRecord place_probes(const Scene& scene, JobSpec& job, const CancelToken& cancel);

/// What the report says of the places of all probes.
Json write_places(const JobSpec& job, const PlacesRecord& record);
/// What a probe's row says of its own.
Json write_place(const ProbePlace& place);

}  // namespace probebake
