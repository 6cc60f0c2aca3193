// A small scene with a cloud in haze, and jobs in it.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "image/exr.h"
#include "scene/generators/cumulus.h"

namespace probebake::test {

inline MediumSpec cloud(const Rgb& absorption, const Rgb& scattering) {
    MediumSpec spec{
        .name = "cloud", .absorption_per_m = absorption, .scattering_per_m = scattering, .g = 0.6};
    GridShape shape{.density = std::make_shared<DensityGrid>(make_cumulus({.size = 32}))};
    shape.index_to_world.linear = glm::dmat3(0.4);
    shape.index_to_world.offset = Vec3(-6.0, 0.0, 4.0);
    spec.shape = std::move(shape);
    return spec;
}

inline MediumSpec haze() {
    return {.name = "haze",
            .absorption_per_m = Rgb(0.01f),
            .scattering_per_m = Rgb(0.02f),
            .g = 0.3,
            .shape = HomogeneousShape{Box{{-20, -5, -10}, {20, 30, 35}}}};
}

/// Of a face, in pixels.
inline constexpr int kFace = 8;
inline constexpr double kTarget = 0.12;  // RMSE

inline const Json kDay = Json::parse(R"({"id": "day",
    "sun": {"direction": [1, 2, 0.5], "irradiance_w_m2": [3, 2, 1]},
    "sky": {"type": "constant", "radiance_w_m2_sr": [0.2, 0.3, 0.5]}})");

inline Json day_request(const Json& targets = {{"rmse", kTarget}}) {
    Json request = small_request(2, targets);
    request["face_size_px"] = kFace;
    request["lighting_states"] = Json::array({kDay});
    return request;
}

class MediaBake : public testing::Test {
  protected:
    MediaBake() { scene_.media = Media({cloud(Rgb(0.1f), Rgb(0.9f)), haze()}); }

    Pilot pilot(const JobSpec& job) const {
        return run_pilot(scene_, job, make_plan(scene_, job), light_state(scene_, job, 0, cancel_),
                         cancel_);
    }
    ProbeResult bake(const JobSpec& job, const UnitParams& unit = {}) const {
        return bake_probe(scene_, job, pilot(job), unit, cancel_);
    }
    static Cubemap cube_of(const ProbeResult& result) {
        return decode_cubemap(result.files[0].bytes, "").cubemap;
    }
    /// JSON pointer of the one thing that is wrong with a job.
    std::string refused(const Json& request) const {
        try {
            make_plan(scene_, read_job(request));
        } catch (const SpecError& error) {
            return error.issues().size() == 1 ? error.issues()[0].pointer : error.what();
        }
        return "";
    }

    Scene scene_ = small_scene();
    CancelToken cancel_;
};

}  // namespace probebake::test
