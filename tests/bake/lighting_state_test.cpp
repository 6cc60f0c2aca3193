#include "bake/lighting_state.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "bake/bake_fixture.h"
#include "bake/pilot.h"
#include "bake/probe_view.h"
#include "scene/generators/generators.h"

namespace probebake {
namespace {

const Json kDay = {{"id", "day"},
                   {"sun",
                    {{"direction", {1, 2, 3}},
                     {"irradiance_w_m2", {900, 850, 800}},
                     {"angular_diameter_deg", 0.53}}},
                   {"sky", {{"type", "constant"}, {"radiance_w_m2_sr", {10, 20, 30}}}}};

Json request_with(const Json& states) {
    Json request = test::small_request(1);
    request["lighting_states"] = states;
    return request;
}

/// The first problem, "" where there is none.
std::string problem_of(const Json& states) {
    try {
        read_job(request_with(states));
        return "";
    } catch (const SpecError& error) {
        return error.issues()[0].pointer + ": " + error.issues()[0].detail;
    }
}

Json day_with(const std::string& pointer, const Json& value) {
    Json day = kDay;
    day[Json::json_pointer(pointer)] = value;
    return Json::array({day});
}

TEST(LightingState, IsReadWithItsDefaults) {
    const JobSpec job = read_job(request_with({"albedo", kDay, "emission"}));
    ASSERT_EQ(job.states.size(), 3u);
    EXPECT_EQ(job.states[0], LightingState::kAlbedo);
    EXPECT_EQ(job.states[2], LightingState::kEmission);
    const LightingState& day = job.states[1];
    EXPECT_TRUE(day.lit());
    EXPECT_EQ(day.id, "day");
    EXPECT_TRUE(day.emission);
    EXPECT_EQ(day.sun->sun.direction, Vec3(1, 2, 3));
    EXPECT_EQ(day.sun->sun.irradiance, Rgb(900.0f, 850.0f, 800.0f));
    EXPECT_EQ(day.sun->rays, 4);
    EXPECT_EQ(std::get<Rgb>(day.sky->what), Rgb(10.0f, 20.0f, 30.0f));
    EXPECT_EQ(day.sky->rays, 64);
    EXPECT_EQ(day.sky->gather_m, 1.0);
    EXPECT_EQ(day.radiance_per, RadiancePer::kFace);
    // Shadow rays go to the voxels; given a cone, what blocks must be solid throughout.
    EXPECT_EQ(day.shadows.cone, 0.0);
    EXPECT_EQ(day.shadows.lod, ShadowLod::kSubtree);
    EXPECT_EQ(day.shadows.threshold, kThesisThreshold);
    EXPECT_EQ(day.shadows.decay, kThesisDecay);
}

TEST(LightingState, TheEffectiveRequestReadsBackAsTheSameJob) {
    const Json gradient = {
        {"id", "dusk"},
        {"emission", false},
        {"radiance_per", "voxel"},
        {"shadows", {{"lod", "node"}, {"cone", 0.125}, {"threshold", 0.2}, {"decay", 1.0}}},
        {"sky",
         {{"type", "gradient"},
          {"zenith_w_m2_sr", {1, 2, 3}},
          {"horizon_w_m2_sr", {4, 5, 6}},
          {"ground_w_m2_sr", {0, 0, 0}},
          {"rays", 16},
          {"gather_m", 2.5}}}};
    const Json picture = {
        {"id", "beach"},
        {"sky",
         {{"type", "equirect"}, {"file", "Beach_1k.hdr"}, {"scale", 20.0}, {"rotation_deg", -90}}}};
    const Json lamps = {{"id", "night"}};
    const JobSpec job = read_job(request_with({kDay, gradient, picture, lamps, "albedo"}));
    const JobSpec again = read_job(write_job(job));
    EXPECT_EQ(again.states, job.states);
    EXPECT_EQ(again.states[1].radiance_per, RadiancePer::kVoxel);
    EXPECT_EQ(again.states[1].shadows, (ShadowSettings{ShadowLod::kNode, 0.125, 0.2, 1.0}));
    EXPECT_EQ(write_job(again), write_job(job));
}

TEST(LightingState, ProblemsAreNamedByTheirPointer) {
    EXPECT_EQ(problem_of({kDay, "albedo"}), "");
    EXPECT_EQ(problem_of({"moon"}),
              "/lighting_states/0: expected \"albedo\", \"emission\" or an object");
    EXPECT_EQ(problem_of({kDay, kDay}), "/lighting_states/1: the state \"day\" is named twice");
    EXPECT_EQ(problem_of(day_with("/id", "albedo")).substr(0, 30),
              "/lighting_states/0/id: \"albedo");
    EXPECT_EQ(problem_of(day_with("/id", "../etc")).substr(0, 22), "/lighting_states/0/id:");
    EXPECT_EQ(problem_of(day_with("/moon", 1)).substr(0, 24), "/lighting_states/0/moon:");
    EXPECT_EQ(problem_of(day_with("/sun/direction", {0, 0, 0})),
              "/lighting_states/0/sun/direction: expected a direction towards the sun");
    EXPECT_EQ(problem_of(day_with("/sun/irradiance_w_m2/1", -1)),
              "/lighting_states/0/sun/irradiance_w_m2/1: expected no negative light");
    EXPECT_EQ(problem_of(day_with("/sun/angular_diameter_deg", 91)).substr(0, 44),
              "/lighting_states/0/sun/angular_diameter_deg:");
    EXPECT_EQ(problem_of(day_with("/sun/colour", 1)).substr(0, 30),
              "/lighting_states/0/sun/colour:");
    EXPECT_EQ(problem_of(day_with("/sky/type", "sunset")).substr(0, 28),
              "/lighting_states/0/sky/type:");
    EXPECT_EQ(problem_of(day_with("/radiance_per", "wall")).substr(0, 32),
              "/lighting_states/0/radiance_per:");
    EXPECT_EQ(problem_of(day_with("/shadows/lod", "soft")).substr(0, 31),
              "/lighting_states/0/shadows/lod:");
    EXPECT_EQ(problem_of(day_with("/shadows/cone", 1.5)).substr(0, 32),
              "/lighting_states/0/shadows/cone:");
    for (const char* file : {"../secret.hdr", "/etc/passwd", ".hidden.exr", "a/b.exr", ""}) {
        const Json sky = {{"type", "equirect"}, {"file", file}};
        EXPECT_EQ(problem_of(day_with("/sky", sky)).substr(0, 28), "/lighting_states/0/sky/file:")
            << file;
    }
    EXPECT_EQ(problem_of(Json::array({{{"id", "dark"}, {"emission", false}}})),
              "/lighting_states/0: expected a sun, a sky or emission");
}

TEST(LightingState, APictureThatIsNotThereIsRefusedBeforeAnythingIsRendered) {
    const Scene scene = test::small_scene();
    const Json sky = {{"type", "equirect"}, {"file", "none.hdr"}};
    const JobSpec job = read_job(request_with({"albedo", day_with("/sky", sky)[0]}));
    try {
        make_plan(scene, job);
        ADD_FAILURE();
    } catch (const SpecError& error) {
        EXPECT_EQ(error.kind(), SpecError::Kind::kUnacceptable);
        EXPECT_EQ(error.issues()[0].pointer, "/lighting_states/1/sky/file");
    }
}

TEST(LightingState, ADamagedPictureIsTheClientsToMend) {
    Scene scene = test::small_scene();
    scene.folder = std::filesystem::temp_directory_path() / "probebake_lighting_state_test";
    std::filesystem::create_directories(scene.folder);
    std::ofstream(scene.folder / "bad.hdr") << "#?RADIANCE\n";
    const Json sky = {{"type", "equirect"}, {"file", "bad.hdr"}};
    const JobSpec job = read_job(request_with(day_with("/sky", sky)));
    make_plan(scene, job);
    try {
        light_state(scene, job, 0, CancelToken());
        ADD_FAILURE();
    } catch (const SpecError& error) {
        EXPECT_EQ(error.issues()[0].pointer, "/lighting_states/0/sky/file");
        EXPECT_EQ(error.issues()[0].detail.find(scene.folder.string()), std::string::npos);
    }
    std::filesystem::remove_all(scene.folder);
}

TEST(LightingState, AMissShowsTheSkyAndAHitItsLight) {
    const Scene scene = test::small_scene();
    const JobSpec job = read_job(request_with(day_with("/sky/rays", 4)));
    const ReadyState state = light_state(scene, job, 0, CancelToken());
    const RenderScene what = render_scene(scene, job.probes[0], state);
    const Vec3 up(0.0, 1.0, 0.0);
    EXPECT_EQ(shade(what, up, Hit{}), Rgb(10.0f, 20.0f, 30.0f));
    Hit ground = trace(scene.tree, {test::kSmallWorldProbe, -up});
    ASSERT_TRUE(ground);
    EXPECT_GT(luminance(shade(what, -up, ground)), 1.0f);
    EXPECT_GT(state.light->cost.sun_rays, 0u);
}

/// Distance closes the small world's net above the ground, the two other ways keep it open.
TEST(LightingState, ShadowRaysFollowTheStatesLevelOfDetail) {
    const Scene scene = test::small_scene();
    const auto light_with = [&](const Json& shadows) {
        Json day = kDay;
        day["shadows"] = shadows;
        const JobSpec job = read_job(request_with(Json::array({day})));
        const ReadyState state = light_state(scene, job, 0, CancelToken());
        const FaceLevel& voxels = state.light->colors.voxels;
        double sum = 0.0;
        for (const PackedRgb value : voxels.values) {
            sum += double{luminance(unpack_rgb(value) * state.light->colors.scale)};
        }
        return sum;
    };
    const double voxels = light_with(Json::object());
    const double subtree = light_with({{"lod", "subtree"}, {"cone", 0.2}});
    const double distance = light_with({{"lod", "distance"}, {"cone", 0.2}});
    EXPECT_NEAR(subtree / voxels, 1.0, 0.02);
    EXPECT_LT(distance / voxels, 0.9);
}

TEST(LightingState, OneValuePerVoxelIsRenderedLikeAColour) {
    const Scene scene = test::small_scene();
    const JobSpec job = read_job(request_with(day_with("/radiance_per", "voxel")));
    const ReadyState state = light_state(scene, job, 0, CancelToken());
    const RenderScene what = render_scene(scene, job.probes[0], state);
    EXPECT_EQ(what.lit, nullptr);
    Hit ground = trace(scene.tree, {test::kSmallWorldProbe, {0.0, -1.0, 0.0}});
    ASSERT_TRUE(ground);
    // The same whichever face is met.
    Hit from_below = ground;
    from_below.entry_face = CubeFace::kNegY;
    EXPECT_GT(luminance(shade(what, {0.0, -1.0, 0.0}, ground)), 1.0f);
    EXPECT_EQ(shade(what, {0.0, 1.0, 0.0}, from_below), shade(what, {0.0, -1.0, 0.0}, ground));
    EXPECT_EQ(state.light->cost.memory_bytes, expected_light_bytes(scene, job));
}

TEST(LightingState, ItsMemoryIsForeseen) {
    for (const GeneratorInfo& info : generators()) {
        if (info.min_size > 128) continue;
        Scene scene = test::small_scene();
        scene.tree = VoxelTree::build(generate({.name = std::string(info.name), .size = 128}));
        const JobSpec job =
            read_job(request_with(Json::array({{{"id", "noon"}, {"sun", kDay["sun"]}}})));
        const ReadyState state = light_state(scene, job, 0, CancelToken());
        const double ratio = static_cast<double>(expected_light_bytes(scene, job)) /
                             static_cast<double>(state.light->cost.memory_bytes);
        EXPECT_GT(ratio, 0.8) << info.name;
        EXPECT_LT(ratio, 1.25) << info.name;
    }
}

}  // namespace
}  // namespace probebake
