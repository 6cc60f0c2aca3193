#include "bake/probe_places.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "image/exr.h"
#include "mesh/mesh_worlds.h"
#include "mesh/voxelise.h"

namespace probebake {
namespace {

/// A room of 8 m within hollow walls of 2 m, from (0, 0, 0) to (12, 12, 12), of one-sided
/// triangles.
Scene room() {
    TriangleMesh mesh;
    mesh.materials.push_back({.double_sided = false});
    test::add_box(mesh, Vec3(6.0), Vec3(6.0));
    test::add_box(mesh, Vec3(6.0), Vec3(-4.0));  // mirrored: faces inwards
    VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = 0.25});
    Scene scene;
    scene.name = "room";
    scene.tree = std::move(made.tree);
    scene.surface = std::move(made.surface);
    scene.mesh = MeshWorld{};
    scene.corner_m = made.corner_m;
    scene.voxel_size_m = 0.25;
    return scene;
}

/// Two probes of the list, in the room and in its wall, and a grid of 2 × 1 × 1 the same.
Json request() {
    return {{"scene", "room"},
            {"face_size_px", 8},
            {"quality", {{"targets", {{"psnr_db", 20.0}}}}},
            {"probes",
             {{"list",
               {{{"id", "air"}, {"position_m", {6.1, 6.2, 6.3}}},
                {{"id", "wall"}, {"position_m", {1.6, 6.2, 6.3}}}}},
              {"grids",
               {{{"id", "g"},
                 {"origin_m", {1.1, 6.2, 6.3}},
                 {"spacing_m", {4.0, 1.0, 1.0}},
                 {"counts", {2, 1, 1}}}}}}}};
}

TEST(ProbePlaces, AreLookedAtByVoxelsAloneUnlessTheJobAsks) {
    const Scene scene = room();
    JobSpec job = read_job(request());
    const PlacesRecord record = place_probes(scene, job, {});
    EXPECT_EQ(record.octree_bytes, 0u);
    for (const ProbeSpec& probe : job.probes) {
        ASSERT_TRUE(probe.place);
        EXPECT_TRUE(probe.place->valid);
        EXPECT_FALSE(probe.place->backface);
        EXPECT_EQ(probe.place->requested_m, probe.position_m);
    }
    const Json report = write_places(job, record);
    EXPECT_EQ(report["invalid"], 0);
    EXPECT_TRUE(report["object_octree"].is_null());
}

TEST(ProbePlaces, TrianglesTellWhichAreInvalid) {
    const Scene scene = room();
    Json asks = request();
    asks["validity"] = Json::object();
    JobSpec job = read_job(asks);
    const PlacesRecord record = place_probes(scene, job, {});
    EXPECT_GT(record.octree_bytes, 0u);
    EXPECT_EQ(record.triangles, 24u);
    EXPECT_TRUE(job.probes[0].place->valid);
    EXPECT_FALSE(job.probes[1].place->valid);
    EXPECT_FALSE(job.probes[2].place->valid);
    EXPECT_TRUE(job.probes[3].place->valid);
    const Json report = write_places(job, record);
    EXPECT_EQ(report["invalid_probes"], Json({"wall", "g-0-0-0"}));
    EXPECT_EQ(report["moved"], 0);
    EXPECT_EQ(report["object_octree"]["triangles"], 24);
    const Json row = write_place(*job.probes[1].place);
    EXPECT_EQ(row["backface"], 1.0);
    EXPECT_EQ(row["valid"], false);
    EXPECT_FALSE(row.contains("requested_position_m"));
    const Plan plan = make_plan(scene, job);
    EXPECT_EQ(plan.warnings.size(), 1u);
    EXPECT_EQ(plan.warnings[0].substr(0, 35), "2 probes stand in places that are i");
}

TEST(ProbePlaces, MoveAsFarAsTheyMay) {
    const Scene scene = room();
    Json asks = request();
    asks["validity"] = {{"relocate", true}};
    JobSpec grids = read_job(asks);
    place_probes(scene, grids, {});
    EXPECT_FALSE(grids.probes[1].place->valid);  // the list's stay: 0 m
    const ProbeSpec& moved = grids.probes[2];
    EXPECT_TRUE(moved.place->valid);
    EXPECT_TRUE(moved.place->moved);
    EXPECT_EQ(moved.place->requested_m, Vec3(1.1, 6.2, 6.3));
    const Vec3 way = glm::abs(moved.position_m - moved.place->requested_m);
    EXPECT_LE(way.x, 0.45 * 4.0 + 1e-12);
    EXPECT_LE(way.y, 0.45 + 1e-12);
    EXPECT_FALSE(grids.probes[3].place->moved);

    asks["validity"]["max_offset_m"] = 1.0;
    JobSpec lists = read_job(asks);
    place_probes(scene, lists, {});
    EXPECT_TRUE(lists.probes[1].place->valid);
    EXPECT_GT(lists.probes[1].position_m.x, 2.0);
    EXPECT_LE(lists.probes[1].position_m.x, 2.6 + 1e-12);
    EXPECT_EQ(write_place(*lists.probes[1].place)["requested_position_m"], Json({1.6, 6.2, 6.3}));
    // What the client asked for is what it gets back.
    EXPECT_EQ(write_job(lists), write_job(read_job(asks)));
}

TEST(ProbePlaces, DoNotDependOnThreads) {
    const Scene scene = room();
    Json asks = request();
    asks["validity"] = {{"relocate", true}, {"max_offset_m", 2.0}};
    asks["probes"]["grids"][0]["counts"] = {4, 9, 9};
    const auto places = [&](int threads) {
        JobSpec job = read_job(asks);
        tbb::task_arena arena(threads);
        arena.execute([&] { place_probes(scene, job, {}); });
        Json all = Json::array();
        for (const ProbeSpec& probe : job.probes) {
            all.push_back({write_place(*probe.place), probe.position_m.x, probe.position_m.y,
                           probe.position_m.z});
        }
        return all;
    };
    EXPECT_EQ(places(1), places(7));
    CancelToken cancel;
    cancel.cancel();
    JobSpec job = read_job(asks);
    EXPECT_THROW(place_probes(scene, job, cancel), Cancelled);
}

TEST(ProbePlaces, AreInTheFilesOfJobsThatAsk) {
    const Scene scene = room();
    const CancelToken cancel;
    const auto attributes = [&](const Json& asks) {
        JobSpec job = read_job(asks);
        place_probes(scene, job, cancel);
        const Plan plan = make_plan(scene, job);
        const Pilot pilot = run_pilot(scene, job, plan, LightingState::kAlbedo, cancel);
        const ProbeResult result = bake_probe(scene, job, pilot, {.probe = 2}, cancel);
        return decode_cubemap(result.files.at(0).bytes, "cube.exr").attributes;
    };
    Json asks = request();
    const ProbeAttributes plain = attributes(asks);
    EXPECT_TRUE(plain.valid);
    EXPECT_FALSE(plain.numbers.contains("probe:closedIn"));
    asks["validity"] = Json::object();
    const ProbeAttributes judged = attributes(asks);
    EXPECT_FALSE(judged.valid);
    EXPECT_EQ(judged.numbers.at("probe:backface"), 1.0);
    EXPECT_EQ(judged.numbers.at("probe:closedIn"), 0.0);
    EXPECT_GT(judged.numbers.at("probe:nearestSurface"), 0.5);
    EXPECT_FALSE(judged.texts.contains("probe:requestedPosition"));
    asks["validity"] = {{"relocate", true}};
    const ProbeAttributes moved = attributes(asks);
    EXPECT_TRUE(moved.valid);
    EXPECT_EQ(moved.texts.at("probe:requestedPosition"), "1.1 6.2 6.3");
    EXPECT_NE(moved.position_m, Vec3(1.1, 6.2, 6.3));
}

}  // namespace
}  // namespace probebake
