// Places of probes over HTTP: asked in a request, told in plan, rows, report, page and files.
#include <gtest/gtest.h>

#include "image/exr.h"
#include "io/file.h"
#include "mesh/mesh_worlds.h"
#include "running_service.h"
#include "scene/gltf_writer.h"

namespace probebake {
namespace {

using test::Answer;
using test::RunningService;

/// As a glTF of one-sided triangles.
std::string room_gltf() {
    const TriangleMesh mesh = test::make_room();
    std::vector<float> positions;
    for (const MeshTriangle& triangle : mesh.triangles) {
        for (const uint32_t vertex : triangle.vertices) {
            for (int axis = 0; axis < 3; ++axis) {
                positions.push_back(static_cast<float>(mesh.positions[vertex][axis]));
            }
        }
    }
    test::GltfWriter writer;
    const int accessor = writer.positions(positions);
    writer.node({{"mesh", writer.mesh({{"attributes", {{"POSITION", accessor}}}})}});
    return writer.text();
}

class ValidityTest : public testing::Test {
  protected:
    static void add_room(ServiceOptions& options) {
        std::filesystem::create_directories(options.scenes);
        write_file_atomically(options.scenes / "room.gltf", room_gltf());
        write_file_atomically(options.scenes / "room.json",
                              R"({"type": "gltf", "file": "room.gltf", "voxel_size_m": 0.25})");
        options.cache.importer = ImportProcess{.program = PROBEBAKE_BINARY,
                                               .scratch = options.data / "temporary",
                                               .limits = {.time = std::chrono::seconds(60)}};
    }
    static Json request() {
        return {{"scene", "room"},
                {"face_size_px", 8},
                {"quality", {{"targets", {{"psnr_db", 20.0}}}}},
                {"probes",
                 {{"list",
                   {{{"id", "air"}, {"position_m", {6.1, 6.2, 6.3}}},
                    {{"id", "wall"}, {"position_m", {1.1, 6.2, 6.3}}}}}}}};
    }
    Json rows(const std::string& id) const {
        return service_.get("/v1/bakes/" + id + "/probes").json().at("rows");
    }
    Json report(const std::string& id) const {
        return service_.get("/v1/bakes/" + id + "/report").json();
    }
    static std::string why_no_octree(const Json& plan) {
        for (const Json& left : plan.at("left_out")) {
            if (left.at("what") == "object octree") return left.at("why");
        }
        return "";
    }

    RunningService service_{add_room};
};

TEST_F(ValidityTest, AJobThatDoesNotAskIsToldWhatVoxelsKnow) {
    const std::string id = service_.bake(request());
    for (const Json& row : rows(id)) {
        const Json& place = row.at("validity");
        EXPECT_EQ(place.at("valid"), true);  // the wall is hollow: air to its voxels
        EXPECT_TRUE(place.at("backface").is_null());
        EXPECT_GT(place.at("nearest_surface_m"), 0.5);
    }
    const Json whole = report(id);
    EXPECT_EQ(why_no_octree(whole.at("plan")),
              "the mesh has become voxels; only validity would ask its triangles");
    EXPECT_TRUE(whole.at("validity").at("object_octree").is_null());
    EXPECT_EQ(whole.at("validity").at("invalid"), 0);
}

TEST_F(ValidityTest, AJobThatAsksIsToldWhatTrianglesKnow) {
    Json asks = request();
    asks["validity"] = Json::object();
    const Json check = service_.post("/v1/bakes:check", asks).json();
    EXPECT_EQ(check.at("validity").at("invalid_probes"), Json({"wall"}));
    EXPECT_EQ(check.at("plan").at("object_octree"), true);
    const std::string id = service_.bake(asks);
    const Json all = rows(id);
    EXPECT_EQ(all.at(0).at("validity").at("valid"), true);
    EXPECT_EQ(all.at(0).at("validity").at("backface"), 0.0);
    EXPECT_EQ(all.at(1).at("validity").at("valid"), false);
    EXPECT_EQ(all.at(1).at("validity").at("backface"), 1.0);
    const Json whole = report(id);
    EXPECT_EQ(why_no_octree(whole.at("plan")), "");
    EXPECT_EQ(whole.at("validity").at("object_octree").at("triangles"), 24);
    EXPECT_EQ(whole.at("validity").at("invalid"), 1);
    const std::string page = service_.get("/v1/bakes/" + id + "/report?format=html").body;
    EXPECT_NE(page.find("2 probes, 0 of them moved, 1 invalid."), std::string::npos);
    const auto cube = [&](const std::string& probe) {
        const std::string body =
            service_.get("/v1/bakes/" + id + "/probes/" + probe + "/albedo/cube.exr").body;
        return decode_cubemap(std::as_bytes(std::span(body)), probe).attributes;
    };
    EXPECT_TRUE(cube("air").valid);
    EXPECT_FALSE(cube("wall").valid);
    EXPECT_EQ(cube("wall").numbers.at("probe:backface"), 1.0);
}

TEST_F(ValidityTest, ProbesMoveWhereTheJobSaysSo) {
    Json asks = request();
    asks["validity"] = {{"relocate", true}, {"max_offset_m", 2.0}};
    const std::string id = service_.bake(asks);
    const Json all = rows(id);
    EXPECT_FALSE(all.at(0).at("validity").contains("requested_position_m"));
    EXPECT_EQ(all.at(1).at("validity").at("requested_position_m"), Json({1.1, 6.2, 6.3}));
    EXPECT_EQ(all.at(1).at("validity").at("valid"), true);
    EXPECT_NE(all.at(1).at("position_m"), Json({1.1, 6.2, 6.3}));
    const Json whole = report(id);
    EXPECT_EQ(whole.at("validity").at("moved"), 1);
    EXPECT_EQ(whole.at("effective_request").at("probes").at("list").at(1).at("position_m"),
              Json({1.1, 6.2, 6.3}));
}

TEST_F(ValidityTest, WhatIsWrongIsNamed) {
    Json asks = request();
    asks["validity"] = {{"max_backface", -0.5}, {"sides", true}};
    const Answer refused = service_.post("/v1/bakes", asks);
    EXPECT_EQ(refused.status, 400);
    asks["validity"].erase("sides");
    const Answer out_of_range = service_.post("/v1/bakes", asks);
    EXPECT_EQ(out_of_range.status, 422);
    EXPECT_EQ(out_of_range.json().at("errors").at(0).at("pointer"), "/validity/max_backface");
}

}  // namespace
}  // namespace probebake
