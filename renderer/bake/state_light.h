// A lighting state ready to be rendered: for lit states the light on every face, computed once and
// shared by the pilot and all units.
#pragma once

#include <memory>

#include "bake/job_spec.h"
#include "light/sky_file.h"
#include "scene/scene.h"

namespace probebake {

struct StateLight {
    FaceColors colors;         // empty where the state has one value per voxel, or media are there
    ColorLevels voxel_values;  // one per voxel; empty elsewhere
    Sky sky;
    LightingCost cost;
    std::string sky_sha256;  // of the picture's file; empty without
};

struct ReadyState {
    LightingState spec;
    std::shared_ptr<const StateLight> light;  // none for states that are not lit

    // A state that needs no light is ready as it is.
    ReadyState(LightingState state = LightingState::kAlbedo,  // NOLINT(google-explicit-constructor)
               std::shared_ptr<const StateLight> its_light = nullptr)
        : spec(std::move(state)), light(std::move(its_light)) {}
};

/// Throws SpecError (unacceptable) where the job's state `index` names a picture that the scene's
/// folder does not hold.
void check_sky_file(const Scene& scene, const JobSpec& job, size_t index);

/// Lights the job's state `index`, where it is a lit one; with Scene::cache_dir, once. Runs on the
/// calling arena. Throws SpecError for a picture that cannot be read, and Cancelled.
ReadyState light_state(const Scene& scene, const JobSpec& job, size_t index,
                       const CancelToken& cancel, const SkySource& skies = read_sky_file);

/// Bytes that the light of all states of a job is expected to take, before it is computed.
uint64_t expected_light_bytes(const Scene& scene, const JobSpec& job);

}  // namespace probebake
