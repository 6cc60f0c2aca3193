#include "bake/state_json.h"

#include <algorithm>

#include "bake/job_names.h"
#include "math/random.h"
#include "scene/scene_library.h"

namespace probebake {
namespace {

constexpr std::array<std::string_view, 3> kSkyNames = {"constant", "gradient", "equirect"};
/// In the order of ShadowLod and RadiancePer.
constexpr std::array<std::string_view, 3> kShadowNames = {"distance", "node", "subtree"};
constexpr std::array<std::string_view, 2> kPerNames = {"face", "voxel"};
constexpr double kMaxLight = 1e9;
constexpr int kMaxSunRays = 1024;
constexpr int kMaxSkyRays = 4096;

/// Three numbers, none of them negative.
Rgb read_light(ObjectReader& reader, const char* key) {
    const Vec3 light = reader.vector(key, kMaxLight, std::nullopt);
    for (int c = 0; c < 3; ++c) {
        if (!(light[c] >= 0.0)) {
            reader.issues().unacceptable(reader.pointer_to(key) + "/" + std::to_string(c),
                                         "expected no negative light");
        }
    }
    return Rgb(light);
}

SunSpec read_sun(ObjectReader reader) {
    SunSpec spec;
    spec.sun.direction = reader.vector("direction", 1e6, std::nullopt);
    if (spec.sun.direction == Vec3(0.0)) {
        reader.issues().unacceptable(reader.pointer_to("direction"),
                                     "expected a direction towards the sun");
    }
    spec.sun.irradiance = read_light(reader, "irradiance_w_m2");
    spec.sun.angular_diameter_deg = reader.number("angular_diameter_deg", {0.0, 90.0}, 0.53);
    spec.rays = static_cast<int>(reader.integer("rays", 1, kMaxSunRays, spec.rays));
    reader.refuse_unknown();
    return spec;
}

SkySpec read_sky(ObjectReader reader) {
    SkySpec spec;
    switch (reader.choice("type", kSkyNames, std::nullopt)) {
        case 0:
            spec.what = read_light(reader, "radiance_w_m2_sr");
            break;
        case 1: {
            SkyGradient gradient;
            gradient.zenith = read_light(reader, "zenith_w_m2_sr");
            gradient.horizon = read_light(reader, "horizon_w_m2_sr");
            gradient.ground = read_light(reader, "ground_w_m2_sr");
            spec.what = gradient;
            break;
        }
        default: {
            SkyFileSpec file;
            file.file = reader.string("file", 64, std::nullopt);
            if (!is_file_name(file.file)) {
                reader.issues().unacceptable(reader.pointer_to("file"),
                                             "expected the name of a file in the scene's folder");
            }
            file.scale =
                reader.number("scale", {.min = 0.0, .max = 1e6, .more_than_min = true}, file.scale);
            file.rotation_deg = reader.number("rotation_deg", {-360.0, 360.0}, file.rotation_deg);
            spec.what = file;
        }
    }
    spec.rays = static_cast<int>(reader.integer("rays", 1, kMaxSkyRays, spec.rays));
    spec.gather_m =
        reader.number("gather_m", {.min = 0.0, .max = 1e4, .more_than_min = true}, spec.gather_m);
    reader.refuse_unknown();
    return spec;
}

ShadowSettings read_shadows(ObjectReader reader) {
    ShadowSettings shadows;
    shadows.lod = static_cast<ShadowLod>(
        reader.choice("lod", kShadowNames, static_cast<size_t>(shadows.lod)));
    shadows.cone = reader.number("cone", {0.0, 1.0}, shadows.cone);
    shadows.threshold = reader.number("threshold", {0.0, 2.0}, shadows.threshold);
    shadows.decay = reader.number("decay", {0.0, 1.0}, shadows.decay);
    reader.refuse_unknown();
    return shadows;
}

LightingState read_lit(const Json& value, const std::string& pointer, JsonIssues& issues) {
    ObjectReader reader(value, pointer, issues);
    LightingState state{.kind = LightingState::Kind::kLit};
    state.id = reader.name("id", std::nullopt);
    if (std::count(kStateNames.begin(), kStateNames.end(), state.id) > 0) {
        issues.unacceptable(reader.pointer_to("id"),
                            "\"" + state.id + "\" is the name of a state without light");
    }
    // object() of an absent field knows it, but gives no state a sun.
    if (reader.has("sun")) {
        state.sun = read_sun(reader.object("sun"));
    } else {
        reader.object("sun");
    }
    if (reader.has("sky")) {
        state.sky = read_sky(reader.object("sky"));
    } else {
        reader.object("sky");
    }
    state.emission = reader.boolean("emission", true);
    state.radiance_per =
        static_cast<RadiancePer>(reader.choice("radiance_per", kPerNames, size_t{0}));
    state.shadows = read_shadows(reader.object("shadows"));
    reader.refuse_unknown();
    if (!state.sun && !state.sky && !state.emission) {
        issues.unacceptable(pointer, "expected a sun, a sky or emission");
    }
    return state;
}

Json triple(const Rgb& color) { return {color.r, color.g, color.b}; }

Json write_sky(const SkySpec& spec) {
    Json json = {
        {"type", kSkyNames[spec.what.index()]}, {"rays", spec.rays}, {"gather_m", spec.gather_m}};
    if (const Rgb* constant = std::get_if<Rgb>(&spec.what)) {
        json["radiance_w_m2_sr"] = triple(*constant);
    } else if (const SkyGradient* gradient = std::get_if<SkyGradient>(&spec.what)) {
        json["zenith_w_m2_sr"] = triple(gradient->zenith);
        json["horizon_w_m2_sr"] = triple(gradient->horizon);
        json["ground_w_m2_sr"] = triple(gradient->ground);
    } else {
        const SkyFileSpec& file = std::get<SkyFileSpec>(spec.what);
        json["file"] = file.file;
        json["scale"] = file.scale;
        json["rotation_deg"] = file.rotation_deg;
    }
    return json;
}

}  // namespace

LightingState read_state(const Json& value, const std::string& pointer, JsonIssues& issues) {
    if (value.is_object()) return read_lit(value, pointer, issues);
    const std::string name = read_name(value, pointer, issues);
    if (name == LightingState::kEmission.id) return LightingState::kEmission;
    if (name != LightingState::kAlbedo.id) {
        issues.unacceptable(pointer, R"(expected "albedo", "emission" or an object)");
    }
    return LightingState::kAlbedo;
}

Json write_state_spec(const LightingState& state) {
    if (!state.lit()) return state.id;
    Json json = {{"id", state.id},
                 {"emission", state.emission},
                 {"radiance_per", kPerNames[static_cast<size_t>(state.radiance_per)]},
                 {"shadows",
                  {{"lod", kShadowNames[static_cast<size_t>(state.shadows.lod)]},
                   {"cone", state.shadows.cone},
                   {"threshold", state.shadows.threshold},
                   {"decay", state.shadows.decay}}}};
    if (state.sun) {
        const Sun& sun = state.sun->sun;
        json["sun"] = {{"direction", {sun.direction.x, sun.direction.y, sun.direction.z}},
                       {"irradiance_w_m2", triple(sun.irradiance)},
                       {"angular_diameter_deg", sun.angular_diameter_deg},
                       {"rays", state.sun->rays}};
    }
    if (state.sky) json["sky"] = write_sky(*state.sky);
    return json;
}

uint64_t stream_of(const LightingState& state) {
    if (!state.lit()) return state.kind == LightingState::Kind::kAlbedo ? 0 : 1;
    uint64_t key = random_key({state.id.size()});
    for (const char c : state.id) key = random_key({key, static_cast<unsigned char>(c)});
    return key;
}

}  // namespace probebake
