// The way of a job over HTTP, from its acceptance to its files.
#include <gtest/gtest.h>

#include "bake/job_size.h"
#include "image/exr.h"
#include "io/sha256.h"
#include "jobs/job.h"
#include "running_service.h"
#include "support/sanitized.h"

namespace probebake {
namespace {

using test::Answer;
using test::RunningService;

TEST(Api, AJobGoesAllTheWay) {
    RunningService service;
    Json request = test::net_request(3);
    request["products"] = {"cube", "aux"};
    request["lighting_states"] = {"albedo", "emission"};
    const Answer taken = service.post("/v1/bakes", request);
    ASSERT_EQ(taken.status, 202) << taken.body;
    const std::string id = taken.json().at("id");
    EXPECT_TRUE(is_job_id(id));
    EXPECT_EQ(taken.header("Location"), "/v1/bakes/" + id);
    EXPECT_FALSE(taken.header("Retry-After").empty());
    EXPECT_EQ(taken.header("Content-Type"), "application/json");

    const Json ended = service.wait_until_ended(id);
    EXPECT_EQ(ended.at("state"), "SUCCEEDED");
    EXPECT_EQ(ended.at("progress").at("units_done"), 6);
    EXPECT_EQ(ended.at("scene"), "net");
    EXPECT_LE(ended.at("created_at").get<std::string>(), ended.at("ended_at").get<std::string>());

    const Answer report = service.get("/v1/bakes/" + id + "/report");
    EXPECT_EQ(report.status, 200);
    EXPECT_EQ(report.header("Content-Type"), "application/json");
    EXPECT_EQ(report.json().at("totals").at("cubemaps"), 6);
    EXPECT_EQ(report.json().at("effective_request").at("scene"), "net");

    const Answer html = service.get("/v1/bakes/" + id + "/report?format=html");
    EXPECT_EQ(html.status, 200);
    EXPECT_EQ(html.header("Content-Type"), "text/html; charset=utf-8");
    EXPECT_EQ(html.header("Content-Security-Policy"),
              "default-src 'none'; style-src 'unsafe-inline'");
    EXPECT_NE(html.body.find("<svg"), std::string::npos);
    EXPECT_EQ(service.get("/v1/bakes/" + id + "/report?format=json").body, report.body);
    EXPECT_EQ(service.get("/v1/bakes/" + id + "/report?format=pdf").status, 400);

    const Json page = service.get("/v1/bakes/" + id + "/probes").json();
    EXPECT_EQ(page.at("final"), true);
    EXPECT_FALSE(page.contains("next_page_token"));
    ASSERT_EQ(page.at("rows").size(), 6U);
    for (const Json& row : page.at("rows")) {
        ASSERT_EQ(row.at("files").size(), 2U);
        for (const Json& file : row.at("files")) {
            const std::string path =
                "/v1/bakes/" + id + "/probes/" + row.at("probe").get<std::string>() + "/" +
                row.at("state").get<std::string>() + "/" + file.at("name").get<std::string>();
            const Answer got = service.get(path);
            ASSERT_EQ(got.status, 200) << path;
            const auto bytes = std::as_bytes(std::span(got.body));
            EXPECT_EQ(got.body.size(), file.at("bytes").get<size_t>());
            EXPECT_EQ(sha256_hex(bytes), file.at("sha256"));
            EXPECT_EQ(got.header("ETag"), "\"" + file.at("sha256").get<std::string>() + "\"");
            EXPECT_EQ(got.header("Content-Type"), "image/x-exr");
            EXPECT_EQ(got.header("Content-Length"), std::to_string(got.body.size()));
            EXPECT_EQ(got.header("Accept-Ranges"), "bytes");
            if (file.at("name") == "cube.exr") {
                EXPECT_EQ(decode_cubemap(bytes, "cube.exr").cubemap.face_size(), 8);
            }
        }
    }
}

TEST(Api, AJobForSphericalHarmonicsHasNoCube) {
    RunningService service;
    Json request = test::net_request(2);
    request["products"] = {"sh"};
    request["quality"]["targets"] = {{"irradiance_rel", 0.5}};
    const std::string id = service.bake(request);
    for (const char* probe : {"p0", "p1"}) {
        const std::string folder = "/v1/bakes/" + id + "/probes/" + probe + "/albedo/";
        EXPECT_EQ(service.get(folder + "cube.exr").status, 404);
        const Answer sh = service.get(folder + "sh.json");
        ASSERT_EQ(sh.status, 200);
        EXPECT_EQ(sh.header("Content-Type"), "application/json");
        EXPECT_EQ(sh.json().at("probe"), probe);
        EXPECT_EQ(sh.json().at("rgb").size(), 9U);
    }
    const Json report = service.get("/v1/bakes/" + id + "/report").json();
    EXPECT_EQ(report.at("target").at("targets").at(0).at("metric"), "irradiance_rel");
    EXPECT_EQ(report.at("states")[0].at("results"), (Json{{"target_met", 2}}));
    EXPECT_TRUE(report.at("states")[0].at("error").contains("irradiance_rel_interval"));
}

TEST(Api, FilesAreComparedByTheirTag) {
    RunningService service;
    const std::string id = service.bake(test::net_request(1));
    const std::string path = "/v1/bakes/" + id + "/probes/p0/albedo/cube.exr";
    const std::string etag = service.get(path).header("ETag");
    for (const std::string& tags : {etag, "W/" + etag, std::string("*"), "\"x\", " + etag}) {
        const Answer same = service.get(path, {{"If-None-Match", tags}});
        EXPECT_EQ(same.status, 304) << tags;
        EXPECT_TRUE(same.body.empty());
        EXPECT_EQ(same.header("ETag"), etag);
    }
    const Answer other = service.get(path, {{"If-None-Match", "\"x\""}});
    EXPECT_EQ(other.status, 200);
    EXPECT_FALSE(other.body.empty());
    httplib::Client client = service.client();
    const httplib::Result head = client.Head(path);
    ASSERT_TRUE(head);
    EXPECT_EQ(head->status, 200);
    EXPECT_EQ(head->get_header_value("Content-Length"), std::to_string(other.body.size()));
}

TEST(Api, AGridsAtlasesLieBesideItsProbes) {
    RunningService service;
    Json request = test::net_request(1);
    request["probes"] = {{"grids",
                          {{{"id", "g"},
                            {"origin_m", {2.1, 3.6, 7.3}},
                            {"spacing_m", {2, 1, 1}},
                            {"counts", {2, 1, 1}}}}}};
    request["products"] = {"ddgi"};
    const std::string id = service.bake(request);
    for (const char* page : {"", "?page_token=u0"}) {  // in the end, and as seen while it ran
        const Json rows =
            service.get("/v1/bakes/" + id + "/probes" + std::string(page)).json().at("rows");
        ASSERT_EQ(rows.size(), 3U);
        EXPECT_TRUE(rows[0].at("files").empty());
        EXPECT_EQ(rows[2].at("grid"), "g");
        ASSERT_EQ(rows[2].at("files").size(), 2U);
        for (const Json& told : rows[2].at("files")) {
            const Answer file = service.get("/v1/bakes/" + id + "/probes/g/albedo/" +
                                            told.at("name").get<std::string>());
            EXPECT_EQ(file.status, 200);
            EXPECT_EQ(sha256_hex(std::as_bytes(std::span(file.body))), told.at("sha256"));
        }
    }
}

TEST(Api, RowsComeInPages) {
    RunningService service;
    const std::string id = service.bake(test::net_request(7));
    std::vector<std::string> probes;
    std::string token;
    int pages = 0;
    do {
        const Json page = service.get("/v1/bakes/" + id + "/probes?page_size=3" + token).json();
        for (const Json& row : page.at("rows")) {
            probes.push_back(row.at("probe"));
            EXPECT_TRUE(row.contains("cost"));
        }
        ++pages;
        token = page.contains("next_page_token")
                    ? "&page_token=" + page["next_page_token"].get<std::string>()
                    : "";
    } while (!token.empty());
    EXPECT_EQ(pages, 3);
    EXPECT_EQ(probes, (std::vector<std::string>{"p0", "p1", "p2", "p3", "p4", "p5", "p6"}));
    for (const char* bad : {"r1", "r999999999", "x0", "", "r", "u", "r-1", "r0x"}) {
        const Answer refused =
            service.get("/v1/bakes/" + id + "/probes?page_token=" + std::string(bad));
        EXPECT_EQ(refused.status, 400) << bad;
        EXPECT_EQ(refused.json().at("errors").at(0).at("pointer"), "?page_token");
    }
    EXPECT_EQ(service.get("/v1/bakes/" + id + "/probes?page_token=u18446744073709551615").status,
              200);
}

TEST(Api, ProbesAreThereWhileTheJobRuns) {
    RunningService service;
    const std::string id = service.submit(test::costly_request(3000, 8));
    const Json running =
        service.wait(id, [](const Json& bake) { return bake["progress"]["units_done"] >= 4; });
    const Json& progress = running.at("progress");
    EXPECT_LE(progress.at("seconds_left_interval").at(0), progress.at("seconds_left"));
    EXPECT_GE(progress.at("seconds_left_interval").at(1), progress.at("seconds_left"));
    const Json page = service.get("/v1/bakes/" + id + "/probes?page_size=2").json();
    EXPECT_EQ(page.at("final"), false);
    ASSERT_EQ(page.at("rows").size(), 2U);
    const Json& row = page.at("rows").at(0);
    const Answer file = service.get("/v1/bakes/" + id + "/probes/" +
                                    row.at("probe").get<std::string>() + "/albedo/cube.exr");
    EXPECT_EQ(file.status, 200);
    EXPECT_EQ(sha256_hex(std::as_bytes(std::span(file.body))), row.at("files").at(0).at("sha256"));
    const Json next = service
                          .get("/v1/bakes/" + id + "/probes?page_size=2&page_token=" +
                               page.at("next_page_token").get<std::string>())
                          .json();
    EXPECT_NE(next.at("rows").at(0).at("probe"), row.at("probe"));

    const Answer later = service.get("/v1/bakes/" + id + "/probes/p2999/albedo/cube.exr");
    EXPECT_EQ(later.status, 404);
    EXPECT_EQ(later.json().at("type"), "urn:probebake:not-baked-yet");
    const Answer report = service.get("/v1/bakes/" + id + "/report");
    EXPECT_EQ(report.status, 409);
    EXPECT_EQ(report.json().at("type"), "urn:probebake:not-finished");
    EXPECT_EQ(service.state(id), "RUNNING") << "the job ended before the test was through";
}

TEST(Api, CancelIsIdempotentAndKeepsFinishedProbes) {
    RunningService service;
    const std::string id = service.submit(test::costly_request(5000, 8));
    service.wait(id, [](const Json& bake) { return bake["progress"]["units_done"] >= 2; });
    const double seconds = test::seconds_of([&] {
        const Answer cancelled = service.post("/v1/bakes/" + id + ":cancel");
        EXPECT_EQ(cancelled.status, 202);
        EXPECT_EQ(cancelled.json().at("state"), "CANCELLING");
        service.wait_until_ended(id);
    });
    EXPECT_LT(seconds, test::patient(1.0));
    const Answer again = service.post("/v1/bakes/" + id + ":cancel");
    EXPECT_EQ(again.status, 200);
    EXPECT_EQ(again.json().at("state"), "CANCELLED");
    const Json page = service.get("/v1/bakes/" + id + "/probes").json();
    EXPECT_EQ(page.at("final"), true) << "nothing more will come";
    ASSERT_GE(page.at("rows").size(), 2U);
    EXPECT_FALSE(page["rows"][0].contains("result"));
    const std::string probe = page["rows"][0]["probe"];
    EXPECT_EQ(service.get("/v1/bakes/" + id + "/probes/" + probe + "/albedo/cube.exr").status, 200);
    const Answer report = service.get("/v1/bakes/" + id + "/report");
    EXPECT_EQ(report.status, 409);
    EXPECT_EQ(report.json().at("type"), "urn:probebake:no-report");
}

TEST(Api, ABakeThatFailedByItsBudgetHasItsReport) {
    RunningService service;
    Json request = test::net_request(2, 16);
    request["quality"] = {{"targets", {{"psnr_db", 90.0}}}};
    request["budget"] = {{"rays", 2 * 6 * 16 * 16}};
    request["on_budget_exhausted"] = "fail";
    const std::string id = service.submit(request);
    EXPECT_EQ(service.wait_until_ended(id).at("state"), "FAILED");
    const Answer report = service.get("/v1/bakes/" + id + "/report");
    ASSERT_EQ(report.status, 200) << report.body;
    EXPECT_EQ(report.json().at("totals").at("cubemaps"), 2);
    EXPECT_EQ(service.get("/v1/bakes/" + id + "/report?format=html").status, 200);
    const Json page = service.get("/v1/bakes/" + id + "/probes").json();
    EXPECT_EQ(page.at("final"), true);
    ASSERT_EQ(page.at("rows").size(), 2U);
    EXPECT_EQ(page["rows"][0].at("result"), "budget_exhausted");
}

TEST(Api, AJobWhoseSceneLoadsIsCancelledWithinASecond) {
    RunningService service;
    Json request = test::net_request(1);
    request["scene"] = "slow";
    const std::string id = service.submit(request);
    service.wait(id, [](const Json& bake) { return bake["state"] == "RUNNING"; });
    const double seconds = test::seconds_of([&] {
        EXPECT_EQ(service.post("/v1/bakes/" + id + ":cancel").status, 202);
        EXPECT_EQ(service.wait_until_ended(id).at("state"), "CANCELLED");
    });
    EXPECT_LT(seconds, test::patient(1.0));
}

TEST(Api, ASmallJobOvertakesALargeOne) {
    RunningService service;
    const std::string large = service.submit(test::costly_request(500, 6));
    service.wait(large, [](const Json& bake) { return bake["progress"]["units_done"] >= 1; });
    const std::string small = service.submit(test::costly_request(8, 6));
    service.wait_until_ended(small);
    const Json behind = service.status(large);
    // Started in turn, the small one's 8 units take as long as 8 or so of the large one's.
    EXPECT_LT(behind.at("progress").at("units_done"), 100);
    EXPECT_EQ(behind.at("state"), "RUNNING");
    service.post("/v1/bakes/" + large + ":cancel");
}

TEST(Api, AFullQueueAndADrainingServiceRefuse) {
    RunningService service([](ServiceOptions& options) {
        options.jobs.max_running = 1;
        options.jobs.max_queued = 1;
    });
    const std::string running = service.submit(test::costly_request(5000, 8));
    service.wait(running, [](const Json& bake) { return bake["state"] == "RUNNING"; });
    service.submit(test::net_request(1));
    const Answer full = service.post("/v1/bakes", test::net_request(1));
    EXPECT_EQ(full.status, 503);
    EXPECT_EQ(full.json().at("type"), "urn:probebake:queue-full");
    EXPECT_FALSE(full.header("Retry-After").empty());

    const std::jthread drain([&] { (*service).drain(std::chrono::milliseconds(1500)); });
    while (service.get("/healthz").json().at("status") != "draining") {
    }
    const Answer draining = service.post("/v1/bakes", test::net_request(1));
    EXPECT_EQ(draining.status, 503);
    EXPECT_EQ(draining.json().at("type"), "urn:probebake:draining");
    EXPECT_FALSE(draining.header("Retry-After").empty());
    const Answer ready = service.get("/readyz");
    EXPECT_EQ(ready.status, 503);
    EXPECT_EQ(ready.json().at("draining"), true);
    EXPECT_EQ(service.state(running), "RUNNING") << "status is served during the grace";
}

TEST(Api, ATenantsShareIsBounded) {
    RunningService service([](ServiceOptions& options) {
        options.jobs.max_running = 1;
        options.jobs.max_per_tenant = 2;
    });
    for (int i = 0; i < 2; ++i) service.submit(test::costly_request(5000, 8));
    const Answer refused = service.post("/v1/bakes", test::net_request(1));
    EXPECT_EQ(refused.status, 429);
    EXPECT_EQ(refused.json().at("type"), "urn:probebake:quota");
    EXPECT_FALSE(refused.header("Retry-After").empty());
}

TEST(Api, WhatTheMemoryCannotHoldIsRefused) {
    const uint64_t unit_bytes = size_of_job(read_job(test::net_request(1, 64))).unit_bytes;
    RunningService service([&](ServiceOptions& options) {
        options.threads = 2;
        options.jobs.memory_bytes = 2 * unit_bytes - 1;
    });
    service.bake(test::net_request(1, 64));
    const Answer refused = service.post("/v1/bakes", test::net_request(2, 64));
    EXPECT_EQ(refused.status, 422) << "two at once do not fit";
    EXPECT_EQ(refused.json().at("errors").at(0).at("pointer"), "/face_size_px");
    EXPECT_EQ(service.get("/v1/bakes").json().at("bakes").size(), 1U);
}

TEST(Api, ListsInStablePages) {
    RunningService service;
    std::vector<std::string> ids;
    for (int i = 0; i < 5; ++i) ids.insert(ids.begin(), service.bake(test::net_request(1)));
    std::vector<std::string> seen;
    std::string token;
    do {
        const Json page = service.get("/v1/bakes?page_size=2" + token).json();
        for (const Json& bake : page.at("bakes")) seen.push_back(bake.at("id"));
        service.bake(test::net_request(1));  // newer than everything on the pages
        token = page.contains("next_page_token")
                    ? "&page_token=" + page["next_page_token"].get<std::string>()
                    : "";
    } while (!token.empty());
    EXPECT_EQ(seen, ids);
    EXPECT_EQ(service.get("/v1/bakes?state=FAILED").json().at("bakes").size(), 0U);
    EXPECT_EQ(service.get("/v1/bakes?state=SUCCEEDED").json().at("bakes").size(), 8U);
}

TEST(Api, CheckShowsThePlanAndKeepsNothing) {
    RunningService service;
    const Answer checked = service.post("/v1/bakes:check", test::net_request(3));
    ASSERT_EQ(checked.status, 200) << checked.body;
    EXPECT_EQ(checked.json().at("valid"), true);
    EXPECT_EQ(checked.json().at("plan").at("work_units"), 3);
    const Json estimate = checked.json().at("estimate");
    EXPECT_GT(estimate.at("seconds"), 0.0);
    EXPECT_GT(estimate.at("memory_bytes"), 0);
    EXPECT_GT(estimate.at("output_bytes"), 0);
    EXPECT_EQ(checked.json().at("effective_request").at("seed"), 5);
    EXPECT_EQ(service.get("/v1/bakes").json().at("bakes").size(), 0U);
    Json bad = test::net_request(1);
    bad["face_size_px"] = 0;
    EXPECT_EQ(service.post("/v1/bakes:check", bad).status, 422);
}

TEST(Api, TellsAboutItself) {
    RunningService service;
    EXPECT_EQ(service.get("/healthz").json().at("status"), "ok");
    EXPECT_EQ(service.get("/").json().at("version"), PROBEBAKE_VERSION);
    EXPECT_EQ(service.get("/").json().at("paths").size(), Api::route_names().size());
    EXPECT_EQ(service.get("/v1/version").json().at("version"), PROBEBAKE_VERSION);
    const Json limits = service.get("/v1/limits").json();
    EXPECT_EQ(limits.at("probes"), 65536);
    EXPECT_EQ(limits.at("request_bytes"), 1 << 20);
    EXPECT_EQ(limits.at("jobs").at("running"), 4);
    const Json scenes = service.get("/v1/scenes").json().at("scenes");
    ASSERT_EQ(scenes.size(), 3U);
    EXPECT_EQ(scenes[0].at("name"), "broken");
    EXPECT_TRUE(scenes[0].contains("error"));
    EXPECT_EQ(scenes[1].at("name"), "net");
    EXPECT_EQ(scenes[1].at("voxel_size_m"), 0.25);
    for (const char* path : {"/", "/healthz", "/v1/version", "/v1/limits", "/v1/scenes"}) {
        EXPECT_EQ(service.get(path + std::string("?x=1")).status, 400) << path;
        EXPECT_EQ(service.client().Head(path)->status, 200) << path;
    }
}

TEST(Api, JobsThatRetentionRemovedAreGone) {
    RunningService service([](ServiceOptions& options) { options.jobs.keep_jobs = 1; });
    const httplib::Headers once = {{"Idempotency-Key", "once"}, {"Prefer", "wait=30"}};
    const std::string first = service.post("/v1/bakes", once, test::net_request(1)).json().at("id");
    service.bake(test::net_request(1));
    for (int i = 0; i < 200 && service.get("/v1/bakes/" + first).status != 410; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    for (const bool restarted : {false, true}) {
        if (restarted) service.restart();
        for (const char* rest :
             {"", "/events", "/report", "/archive.tar", "/probes", "/probes/p0/albedo/cube.exr"}) {
            const Answer gone = service.get("/v1/bakes/" + first + rest);
            EXPECT_EQ(gone.status, 410) << rest;
            EXPECT_EQ(gone.json().at("type"), "urn:probebake:expired");
        }
        EXPECT_EQ(service.post("/v1/bakes/" + first + ":cancel").status, 410);
        EXPECT_EQ(service.remove("/v1/bakes/" + first).status, 410);
        const Answer again = service.post("/v1/bakes", once, test::net_request(1));
        EXPECT_EQ(again.status, 410) << "not baked once more";
    }
    EXPECT_EQ(service.get("/v1/bakes/b-0").status, 404);
}

}  // namespace
}  // namespace probebake
