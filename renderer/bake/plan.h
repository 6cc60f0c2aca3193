// Plan: what a job needs of a scene, what it leaves out and why, and what it will hold in memory.
//
// A pure function of scene and job, made before anything is rendered; the report shows it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/media_state.h"
#include "scene/scene.h"

namespace probebake {

/// Something that this service can do and that this job does without.
struct LeftOut {
    std::string what;
    std::string why;
};

struct Plan {
    /// Renderers that the search may choose from; one where the client chose.
    std::vector<RendererKind> renderers;
    bool needs_error_table = false;
    bool leaf_rays_only = false;  // one per pixel to begin with; nothing is searched
    bool needs_pilot = false;     // to search settings
    bool needs_audit = false;
    /// Of a mesh's triangles, to look at the places of probes; dropped before anything is rendered.
    bool needs_object_octree = false;
    /// Where a state is seen through media: how.
    std::optional<MediaPlan> media;
    std::vector<LeftOut> left_out;
    std::vector<std::string> warnings;
    uint64_t work_units = 0;  // probes × states
    uint64_t texels = 0;
    uint64_t scene_bytes = 0;     // tree, colours and media, shared by all jobs on the scene
    uint64_t light_bytes = 0;     // of all lit states together, expected (all are held at once)
    uint64_t bytes_per_unit = 0;  // largest work unit while it is rendered and encoded
    uint64_t output_bytes = 0;    // at most: uncompressed products
};

/// Throws SpecError (unacceptable) for a job that this scene cannot serve.
Plan make_plan(const Scene& scene, const JobSpec& job);

Json write_plan(const Plan& plan);

}  // namespace probebake
