// LightingState: what a hit shows, as a client asked for it; its id is a folder of the result.
//
// `albedo` is reflectance (unit 1), `emission` the radiance of emissive voxels alone; every other
// state is lit (W·m⁻²·sr⁻¹): sun and sky with the shadows that the scene casts, and its emissive
// voxels (light/lighting.h).
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "light/lighting.h"

namespace probebake {

struct SkyFileSpec {
    std::string file;  // an equirectangular picture in the scene's folder
    double scale = 1.0;
    double rotation_deg = 0.0;

    bool operator==(const SkyFileSpec&) const = default;
};

struct SkySpec {
    std::variant<Rgb, SkyGradient, SkyFileSpec> what = Rgb(0.0f);
    int rays = 64;          // per gathering
    double gather_m = 1.0;  // edge of the nodes that gather it

    bool operator==(const SkySpec&) const = default;
};

struct SunSpec {
    Sun sun;
    int rays = 4;  // per voxel face

    bool operator==(const SunSpec&) const = default;
};

/// What holds a lit value: a voxel's face, or the whole voxel as in the thesis, which leaks through
/// thin walls (light/voxel_values.h).
enum class RadiancePer { kFace, kVoxel };

struct LightingState {
    enum class Kind { kAlbedo, kEmission, kLit };

    Kind kind = Kind::kAlbedo;
    std::string id = "albedo";
    // Of lit states:
    std::optional<SunSpec> sun;
    std::optional<SkySpec> sky;
    bool emission = true;
    RadiancePer radiance_per = RadiancePer::kFace;
    ShadowSettings shadows;

    static const LightingState kAlbedo;
    static const LightingState kEmission;

    bool lit() const { return kind == Kind::kLit; }
    bool operator==(const LightingState&) const = default;
};

inline const LightingState LightingState::kAlbedo{};
inline const LightingState LightingState::kEmission{.kind = Kind::kEmission, .id = "emission"};

inline const std::string& name_of(const LightingState& state) { return state.id; }

/// Names the state's random streams; no matter where in the job it stands.
uint64_t stream_of(const LightingState& state);

}  // namespace probebake
