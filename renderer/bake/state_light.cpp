#include "bake/state_light.h"

#include <algorithm>
#include <chrono>
#include <functional>

#include "bake/probe_view.h"
#include "bake/state_json.h"
#include "io/cache_folder.h"
#include "io/io_error.h"
#include "io/sha256.h"
#include "light/face_file.h"
#include "light/light_memory.h"
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

Sky make_sky(const Scene& scene, const JobSpec& job, size_t index, const SkySource& skies,
             StateLight& out) {
    const LightingState& state = job.states[index];
    if (!state.sky) return Sky();
    if (const Rgb* constant = std::get_if<Rgb>(&state.sky->what)) return Sky(*constant);
    if (const SkyGradient* gradient = std::get_if<SkyGradient>(&state.sky->what)) {
        return Sky(*gradient);
    }
    const SkyFileSpec& file = *picture_of(state);
    try {
        SkyFile picture = skies(scene.folder / file.file);
        out.sky_sha256 = picture.sha256;
        return Sky(SkyPicture{std::move(picture.image), file.scale, file.rotation_deg});
    } catch (const IoError& error) {
        // Its text may begin with a path that is none of the client's business.
        const std::string text = error.what();
        refuse_picture(index, text.rfind(file.file, 0) == 0 ? text : file.file + " cannot be read");
    }
}

/// Changes whenever the same scene is lit in another way.
constexpr std::string_view kLightVersion = "probebake light 1\n";

/// Digest of all that the light of a state depends on.
std::string cache_key(const Scene& scene, const LightingState& state, const StateLight& light,
                      uint64_t seed) {
    Json spec = write_state_spec(state);
    spec.erase("id");
    Sha256 sha;
    sha.update(kLightVersion);
    sha.update(scene.sha256 + "\n" + light.sky_sha256 + "\n" + std::to_string(seed) + "\n");
    sha.update(dump_json(spec));
    return sha.hex();
}

/// From the scene's cache, or made now and kept there.
LitScene light_once(const Scene& scene, const std::string& key,
                    const std::function<LitScene()>& make) {
    if (!scene.cache_dir) return make();
    const std::filesystem::path path = *scene.cache_dir / (key + ".light");
    const auto start = std::chrono::steady_clock::now();
    try {
        LitScene lit = load_light(path, scene.tree);
        mark_used(path);
        lit.cost.from_cache = true;
        lit.cost.seconds = lit.cost.wall_seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return lit;
    } catch (const IoError&) {  // not there, or not whole
    }
    LitScene lit = make();
    try {
        save_light(path, lit);
    } catch (const IoError&) {  // costs time later, nothing else
    }
    return lit;
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
                       const CancelToken& cancel, const SkySource& skies) {
    const LightingState& state = job.states[index];
    if (!state.lit()) return state;
    auto light = std::make_shared<StateLight>();
    light->sky = make_sky(scene, job, index, skies, *light);
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
    LitScene lit = light_once(scene, cache_key(scene, state, *light, params.seed),
                              [&] { return light_scene(scene.tree, lighting, params, cancel); });
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
