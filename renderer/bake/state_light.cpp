#include "bake/state_light.h"

#include <algorithm>

#include "bake/probe_view.h"
#include "io/file_beneath.h"
#include "io/sha256.h"
#include "light/light_memory.h"
#include "light/sky_file.h"
#include "light/voxel_values.h"

namespace probebake {
namespace {

const SkyFileSpec* picture_of(const LightingState& state) {
    return state.sky ? std::get_if<SkyFileSpec>(&state.sky->what) : nullptr;
}

[[noreturn]] void refuse_picture(size_t state, const std::string& why) {
    throw SpecError(SpecError::Kind::kUnacceptable,
                    "/lighting_states/" + std::to_string(state) + "/sky/file", why);
}

Sky make_sky(const Scene& scene, const JobSpec& job, size_t index, StateLight& out) {
    const LightingState& state = job.states[index];
    if (!state.sky) return Sky();
    if (const Rgb* constant = std::get_if<Rgb>(&state.sky->what)) return Sky(*constant);
    if (const SkyGradient* gradient = std::get_if<SkyGradient>(&state.sky->what)) {
        return Sky(*gradient);
    }
    const SkyFileSpec& file = *picture_of(state);
    try {
        const std::vector<std::byte> bytes =
            read_file_beneath(scene.folder / file.file, kMaxSkyFileBytes);
        out.sky_sha256 = sha256_hex(bytes);
        return Sky(SkyPicture{decode_sky(bytes, file.file), file.scale, file.rotation_deg});
    } catch (const IoError& error) {
        // Its text may begin with a path that is none of the client's business.
        const std::string text = error.what();
        refuse_picture(index, text.rfind(file.file, 0) == 0 ? text : file.file + " cannot be read");
    }
}

}  // namespace

void check_sky_file(const Scene& scene, const JobSpec& job, size_t index) {
    const SkyFileSpec* picture = picture_of(job.states[index]);
    if (picture == nullptr) return;
    std::error_code error;
    if (!std::filesystem::is_regular_file(scene.folder / picture->file, error)) {
        refuse_picture(index, "there is no file \"" + picture->file + "\" in the scene's folder");
    }
}

ReadyState light_state(const Scene& scene, const JobSpec& job, size_t index,
                       const CancelToken& cancel) {
    const LightingState& state = job.states[index];
    if (!state.lit()) return state;
    auto light = std::make_shared<StateLight>();
    light->sky = make_sky(scene, job, index, *light);
    if (!scene.media.empty()) return {state, std::move(light)};  // paths meet sun and sky
    Lighting lighting{.sky = light->sky, .emission = state.emission};
    LightingParams params{
        .shadow = state.shadows,
        .seed = random_key({job.seed, static_cast<uint64_t>(StreamPurpose::kLighting)})};
    if (state.sun) {
        lighting.sun = state.sun->sun;
        params.sun_rays = state.sun->rays;
    }
    if (state.sky) {
        params.sky_rays = state.sky->rays;
        params.gather_level = gather_level_for(scene.voxel_size_m, state.sky->gather_m);
    }
    LitScene lit = light_scene(scene.tree, lighting, params, cancel);
    light->cost = lit.cost;
    if (state.radiance_per == RadiancePer::kVoxel) {
        light->voxel_values = one_value_per_voxel(scene.tree, lit.colors);
        light->cost.memory_bytes = light->voxel_values.memory_bytes();
    } else {
        light->colors = std::move(lit.colors);
    }
    return {state, std::move(light)};
}

uint64_t expected_light_bytes(const Scene& scene, const JobSpec& job) {
    if (!scene.media.empty()) return 0;
    const auto count_of = [&](RadiancePer per) {
        return static_cast<uint64_t>(std::count_if(
            job.states.begin(), job.states.end(),
            [&](const LightingState& s) { return s.lit() && s.radiance_per == per; }));
    };
    const uint64_t per_face = count_of(RadiancePer::kFace);
    return (per_face > 0 ? per_face * expected_face_bytes(scene.tree) : 0) +
           count_of(RadiancePer::kVoxel) * voxel_value_bytes(scene.tree);
}

}  // namespace probebake
