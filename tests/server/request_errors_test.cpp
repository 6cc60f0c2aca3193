// What a client may get wrong, and what it is told.
#include <gtest/gtest.h>

#include "bake/job_size.h"
#include "running_service.h"

namespace probebake {
namespace {

using test::Answer;
using test::RunningService;

/// Status and pointer of the first error, e.g. "422 /face_size_px".
std::string verdict(const Answer& answer) {
    const Json problem = answer.json();
    EXPECT_EQ(answer.header("Content-Type"), "application/problem+json");
    for (const char* member : {"type", "title", "status", "detail", "request_id"}) {
        EXPECT_TRUE(problem.contains(member)) << member;
    }
    EXPECT_EQ(problem.at("status"), answer.status);
    EXPECT_EQ(problem.at("request_id"), answer.header("X-Request-Id"));
    EXPECT_EQ(problem.at("type").get<std::string>().rfind("urn:probebake:", 0), 0U);
    std::string text = std::to_string(answer.status);
    if (problem.contains("errors")) {
        const Json& error = problem["errors"].at(0);
        EXPECT_FALSE(error.at("detail").get<std::string>().empty());
        text += " " + error.at("pointer").get<std::string>();
    }
    return text;
}

TEST(RequestErrors, AFileOfTheSceneThatCannotBeReadIsTold) {
    const RunningService service;
    test::write_text(service.scenes() / "elsewhere.bytes", "VOX ");
    std::filesystem::create_symlink("elsewhere.bytes", service.scenes() / "linked.vox");
    test::write_text(service.scenes() / "linked.json",
                     R"({"type": "vox", "file": "linked.vox", "voxel_size_m": 1})");
    Json request = test::net_request(1);
    request["scene"] = "linked";
    for (const char* path : {"/v1/bakes", "/v1/bakes:check"}) {
        const Answer answer = service.post(path, request.dump());
        EXPECT_EQ(verdict(answer), "422 /scene") << path;
        EXPECT_NE(answer.body.find("linked.vox"), std::string::npos) << answer.body;
    }
}

TEST(RequestErrors, PointAtWhatIsWrong) {
    const RunningService service;
    const auto changed = [](const std::string& pointer, const Json& value) {
        Json request = test::net_request(2);
        request[Json::json_pointer(pointer)] = value;
        return request.dump();
    };
    const Json grid = {{"id", "g"},
                       {"origin_m", {0, 0, 0}},
                       {"spacing_m", {1, 1, 1}},
                       {"counts", {1000, 1000, 1000}}};
    const std::vector<std::pair<std::string, std::string>> cases = {
        {changed("/colour", 1), "400 /colour"},
        {changed("/probes/list/1/positon_m", 1), "400 /probes/list/1/positon_m"},
        {changed("/a~1b", 1), "400 /a~1b"},
        {changed("/face_size_px", "64"), "400 /face_size_px"},
        {changed("/face_size_px", 64.7), "400 /face_size_px"},
        {changed("/face_size_px", 0), "422 /face_size_px"},
        {changed("/face_size_px", 1e300), "400 /face_size_px"},
        {changed("/seed", -1), "422 /seed"},
        {changed("/probes/list/0/position_m/1", 1e7), "422 /probes/list/0/position_m/1"},
        {changed("/probes/list/0/position_m/1", nullptr), "400 /probes/list/0/position_m/1"},
        {changed("/probes/list/1/id", "p0"), "422 /probes/list/1/id"},
        {changed("/probes/list/1/id", "../p0"), "400 /probes/list/1/id"},
        {changed("/probes/grids", Json::array({grid})), "422 /probes/grids/0/counts"},
        {changed("/quality/targets/psnr_db", -3), "422 /quality/targets/psnr_db"},
        {changed("/scene", "../net"), "400 /scene"},
        {changed("/scene", "atlantis"), "404 /scene"},
        {changed("/scene", "broken"), "422 /scene"},
        {"[]", "400 "},
        {"{", "400 "},
        {"not json", "400 "},
        {"{\"scene\": NaN}", "400 "},
        {"{\"seed\": 1e999}", "400 "},
        {"{\"scene\": \"net\", \"scene\": \"net\"}", "400 "},
        {"{\"scene\": \"\xff\"}", "400 "},
        {std::string(1000, '[') + std::string(1000, ']'), "400 "},
        {"[" + std::string(400'000, '0') + "]", "400 "},
    };
    for (const auto& [body, expected] : cases) {
        for (const char* path : {"/v1/bakes", "/v1/bakes:check"}) {
            EXPECT_EQ(verdict(service.post(path, body)), expected) << path << body.substr(0, 300);
        }
    }
    std::string many = "[0";
    for (int i = 0; i < 120'000; ++i) many += ",0";
    EXPECT_EQ(verdict(service.post("/v1/bakes", many + "]")), "400 ");
    EXPECT_TRUE(service.get("/v1/bakes").json().at("bakes").empty()) << "something was accepted";
}

TEST(RequestErrors, SeveralAreToldAtOnce) {
    const RunningService service;
    Json request = test::net_request(1);
    request["face_size_px"] = 0;
    request["seed"] = -1;
    request["colour"] = 1;
    const Answer answer = service.post("/v1/bakes", request);
    EXPECT_EQ(answer.status, 400);
    EXPECT_EQ(answer.json().at("errors").size(), 3U);
}

TEST(RequestErrors, TheQueryIsReadStrictly) {
    const RunningService service;
    EXPECT_EQ(verdict(service.get("/v1/bakes?page_size=0")), "400 ?page_size");
    EXPECT_EQ(verdict(service.get("/v1/bakes?page_size=101")), "400 ?page_size");
    EXPECT_EQ(verdict(service.get("/v1/bakes?page_size=1&page_size=2")), "400 ?page_size");
    EXPECT_EQ(verdict(service.get("/v1/bakes?page_token=b")), "400 ?page_token");
    EXPECT_EQ(verdict(service.get("/v1/bakes?state=running")), "400 ?state");
    EXPECT_EQ(verdict(service.get("/v1/bakes?limit=3")), "400 ?limit");
    EXPECT_EQ(verdict(service.post("/v1/bakes?dry=1", test::net_request(1))), "400 ?dry");
}

TEST(RequestErrors, PathsLeadNowhereElse) {
    RunningService service;
    const std::string id = service.bake(test::net_request(1));
    const std::string probes = "/v1/bakes/" + id + "/probes/";
    for (const std::string& path : {std::string("//"),
                                    std::string("/v2/bakes"),
                                    std::string("/v1/bakes/"),
                                    "/v1/bakes/" + id + "/",
                                    "/v1/bakes/" + id + "/files",
                                    "/v1/bakes/" + id + "0",
                                    std::string("/v1/bakes/.."),
                                    std::string("/v1/bakes/../../etc/passwd"),
                                    std::string("/v1/bakes/%2e%2e%2f%2e%2e/report"),
                                    "/v1/bakes/" + id + "%00",
                                    probes + "p0/albedo/cube.exr%00.txt",
                                    probes + "p0/albedo/%2e%2e",
                                    probes + "..%2f..%2fp0/albedo/cube.exr",
                                    probes + "p0/../albedo/cube.exr",
                                    probes + "p0/emission/cube.exr",
                                    probes + "p0/albedo/aux.exr",
                                    probes + "p1/albedo/cube.exr",
                                    probes + "p0/albedo/cube.exr/",
                                    probes + "P0/albedo/cube.exr",
                                    probes + "p0/albedo/report.json",
                                    probes + "%ff/albedo/cube.exr"}) {
        const Answer answer = service.get(path);
        EXPECT_EQ(answer.status, 404) << path << answer.body;
        EXPECT_EQ(verdict(answer), "404") << path;
    }
}

TEST(RequestErrors, WrongMethodsAreToldTheRightOnes) {
    const RunningService service;
    httplib::Client client = service.client();
    const httplib::Result deleted = client.Delete("/v1/bakes");
    ASSERT_TRUE(deleted);
    EXPECT_EQ(deleted->status, 405);
    EXPECT_EQ(deleted->get_header_value("Allow"), "POST, GET, HEAD");
    EXPECT_EQ(parse_json(deleted->body).at("type"), "urn:probebake:method-not-allowed");
    EXPECT_EQ(client.Put("/healthz", "{}", "application/json")->status, 405);
    EXPECT_EQ(client.Patch("/v1/scenes", "{}", "application/json")->status, 405);
    EXPECT_EQ(client.Options("/v1/bakes")->status, 405);
    EXPECT_EQ(service.get("/v1/bakes:check").status, 405);
    EXPECT_EQ(service.post("/v1/limits").status, 405);
    EXPECT_EQ(client.Put("/nowhere", "{}", "application/json")->status, 404);
}

TEST(RequestErrors, ABodyIsJson) {
    const RunningService service;
    const std::string body = test::net_request(1).dump();
    EXPECT_EQ(service.post("/v1/bakes", body, "text/plain").status, 415);
    EXPECT_EQ(service.post("/v1/bakes", body, "application/x-www-form-urlencoded").status, 415);
    EXPECT_EQ(service.post("/v1/bakes", body, "application/json; charset=utf-8").status, 202);
    EXPECT_EQ(service.post("/v1/bakes").status, 400);
    const std::string id = service.submit(test::net_request(1));
    EXPECT_EQ(service.post("/v1/bakes/" + id + ":cancel", std::string("{}")).status, 400);
}

TEST(RequestErrors, WhatTheDiskCannotHoldIsRefused) {
    const RunningService service;
    Json request = test::net_request(40, 4096);
    request["products"] = {"cube", "aux", "latlong", "gl_faces", "specular"};
    const JobSize size = size_of_job(read_job(request));
    EXPECT_GT(size.output_bytes, uint64_t{150} << 30);
    if (std::filesystem::space(service.options().data).available > size.output_bytes) {
        GTEST_SKIP() << "a disk with that much room";
    }
    const Answer answer = service.post("/v1/bakes", request);
    // Where the machine has less memory than such a cubemap takes, that is said.
    EXPECT_TRUE(answer.status == 503 || answer.status == 422) << answer.body;
    EXPECT_EQ(service.get("/v1/bakes").json().at("bakes").size(), 0U);
}

}  // namespace
}  // namespace probebake
