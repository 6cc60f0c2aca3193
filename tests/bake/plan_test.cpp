#include "bake/plan.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "bake/bake_fixture.h"

namespace probebake {
namespace {

bool leaves_out(const Plan& plan, const std::string& what) {
    return std::any_of(plan.left_out.begin(), plan.left_out.end(),
                       [&](const LeftOut& left) { return left.what == what && !left.why.empty(); });
}

TEST(Plan, LeavesOutWhatTheJobDoesNotNeed) {
    const Scene scene = test::small_scene();
    const Plan searched = make_plan(scene, test::small_job());
    EXPECT_TRUE(searched.needs_error_table);
    EXPECT_TRUE(searched.needs_pilot);
    EXPECT_TRUE(searched.needs_audit);
    EXPECT_FALSE(leaves_out(searched, "quality search"));
    EXPECT_TRUE(leaves_out(searched, "emission colours"));
    EXPECT_TRUE(leaves_out(searched, "aux file"));

    Json request = test::small_request();
    request["quality"]["renderer"] = "reference";
    request["quality"]["settings"] = {{"leaf_grid", 4}};
    request["quality"]["evidence"] = {{"audit", false}};
    request["products"] = {"cube", "aux"};
    const Plan fixed = make_plan(scene, read_job(request));
    EXPECT_FALSE(fixed.needs_error_table);
    EXPECT_TRUE(leaves_out(fixed, "error table"));
    EXPECT_TRUE(leaves_out(fixed, "quality search"));
    EXPECT_TRUE(leaves_out(fixed, "audit"));
    EXPECT_FALSE(leaves_out(fixed, "aux file"));
    EXPECT_EQ(fixed.renderers, std::vector{RendererKind::kReference});
}

TEST(Plan, CountsAndWarns) {
    const Scene scene = test::small_scene();
    Json request = test::small_request(3);
    request["lighting_states"] = {"albedo", "emission"};
    const Vec3 inside = scene.to_metres(Vec3(10.5, 5.5, 10.5));
    request["probes"]["list"][0]["position_m"] = {inside.x, inside.y, inside.z};
    const Plan plan = make_plan(scene, read_job(request));
    EXPECT_EQ(plan.work_units, 6u);
    EXPECT_EQ(plan.texels, 6u * 6 * 256);
    EXPECT_EQ(plan.scene_bytes, scene.tree.memory_bytes());
    EXPECT_GT(plan.bytes_per_unit, 6u * 256 * 12);
    ASSERT_EQ(plan.warnings.size(), 1u);
    EXPECT_NE(plan.warnings[0].find("1 probes lie in a voxel"), std::string::npos);
    EXPECT_EQ(write_plan(plan)["work_units"], 6u);
}

TEST(Plan, AJobThatTakesMoreMemoryThanItMayIsRefused) {
    const Scene scene = test::small_scene();
    JobSpec job = test::small_job();
    const Plan plan = make_plan(scene, job);
    job.budget.memory_bytes = plan.scene_bytes + plan.light_bytes + plan.bytes_per_unit;
    EXPECT_NO_THROW(make_plan(scene, job));
    --*job.budget.memory_bytes;
    try {
        make_plan(scene, job);
        FAIL() << "planned";
    } catch (const SpecError& error) {
        ASSERT_EQ(error.issues().size(), 1u);
        EXPECT_EQ(error.issues()[0].pointer, "/budget/memory_bytes");
    }
}

TEST(Plan, MakesAnObjectOctreeOnlyWhereValidityAsksAMesh) {
    const auto why = [](const Plan& plan) -> std::string {
        for (const LeftOut& left : plan.left_out) {
            if (left.what == "object octree") return left.why;
        }
        return "";
    };
    Scene scene = test::small_scene();
    Json request = test::small_request();
    const JobSpec plain = read_job(request);
    request["validity"] = Json::object();
    const JobSpec asks = read_job(request);
    EXPECT_EQ(why(make_plan(scene, asks)), "the scene has no mesh");
    EXPECT_FALSE(make_plan(scene, asks).needs_object_octree);
    scene.mesh = MeshWorld{};
    EXPECT_EQ(why(make_plan(scene, asks)), "all surfaces of the mesh have two fronts, or holes");
    scene.surface.triangles.resize(1);
    scene.surface.one_sided = 1;
    EXPECT_EQ(why(make_plan(scene, plain)),
              "the mesh has become voxels; only validity would ask its triangles");
    EXPECT_EQ(write_plan(make_plan(scene, plain))["object_octree"], false);
    const Plan plan = make_plan(scene, asks);
    EXPECT_TRUE(plan.needs_object_octree);
    EXPECT_EQ(why(plan), "");
    EXPECT_EQ(write_plan(plan)["object_octree"], true);
}

}  // namespace
}  // namespace probebake
