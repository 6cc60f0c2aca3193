// Idempotent submission, waiting, events, parts of files, archives, deletion, metrics.
#include <gtest/gtest.h>

#include <sys/wait.h>

#include <atomic>

#include "http/file_answer.h"
#include "http/query.h"
#include "io/sha256.h"
#include "raw_client.h"
#include "running_service.h"

namespace probebake {
namespace {

using test::Answer;
using test::RunningService;

std::string path_of(const std::string& id) { return "/v1/bakes/" + id; }

/// The last id in a stream of events; empty where there was none.
std::string last_id(const std::string& events) {
    const size_t at = events.rfind("\nid: ");
    if (at == std::string::npos) return "";
    return events.substr(at + 5, events.find('\n', at + 5) - at - 5);
}

/// All events of a job up to its last, as a client reads them: a stream ends after a while, the
/// next goes on behind what was seen. `begun` is called once the first event has come.
std::string follow(const RunningService& service, const std::string& id,
                   const std::function<void()>& begun) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    std::string events;
    bool told = false;
    while (events.find("event: end\n") == std::string::npos) {
        if (std::chrono::steady_clock::now() > give_up) {
            ADD_FAILURE() << "no end: " << events;
            break;
        }
        const std::string last = last_id(events);
        const httplib::Headers headers =
            last.empty() ? httplib::Headers{} : httplib::Headers{{"Last-Event-ID", last}};
        const auto read = [&](const char* data, size_t size) {
            events.append(data, size);
            if (!told && !last_id(events).empty()) {
                told = true;
                begun();
            }
            return true;
        };
        EXPECT_TRUE(service.client().Get(path_of(id) + "/events", headers, read));
    }
    return events;
}

TEST(ApiWaiting, AKeyMakesASubmissionOneJob) {
    RunningService service;
    const Json request = test::net_request(1);
    const Answer first = service.post("/v1/bakes", {{"Idempotency-Key", "a-1"}}, request);
    const Answer again = service.post("/v1/bakes", {{"Idempotency-Key", "a-1"}}, request);
    ASSERT_EQ(first.status, 202);
    EXPECT_EQ(again.status, 202);
    EXPECT_EQ(again.header("Idempotency-Replayed"), "true");
    EXPECT_EQ(again.json().at("id"), first.json().at("id"));
    EXPECT_EQ(again.header("Location"), first.header("Location"));
    const Answer other =
        service.post("/v1/bakes", {{"Idempotency-Key", "a-1"}}, test::net_request(2));
    EXPECT_EQ(other.status, 422);
    EXPECT_EQ(other.json().at("type"), "urn:probebake:key-reused");
    service.restart();
    // Where the scene is gone by now, too.
    service.wait_until_ended(first.json().at("id"));
    std::filesystem::remove(service.scenes() / "net.json");
    EXPECT_EQ(service.post("/v1/bakes", request).status, 404);
    EXPECT_EQ(service.post("/v1/bakes", {{"Idempotency-Key", "a-1"}}, request).json().at("id"),
              first.json().at("id"));
    EXPECT_EQ(service.get("/v1/bakes").json().at("bakes").size(), 1U);
    for (const std::string& bad : {std::string(256, 'k'), std::string("a b"), std::string("%41")}) {
        EXPECT_EQ(service.post("/v1/bakes", {{"Idempotency-Key", bad}}, request).status, 400)
            << bad;
    }
}

TEST(ApiWaiting, ASubmissionMayWaitForItsEnd) {
    RunningService service;
    Json quick = test::costly_request(1, 6);
    quick["quality"]["settings"]["leaf_grid"] = 4;
    Answer done;
    for (int i = 0; i < 5 && done.status != 201; ++i) {
        const double seconds = test::seconds_of([&] {
            done = service.post("/v1/bakes", {{"Prefer", "wait=30"}}, quick);
        });
        EXPECT_TRUE(done.status == 201 || seconds >= 30.0) << "answered before either";
    }
    EXPECT_EQ(done.status, 201);
    EXPECT_EQ(done.json().at("state"), "SUCCEEDED");
    Answer slow;
    const double seconds = test::seconds_of([&] {
        slow = service.post("/v1/bakes", {{"Prefer", "wait=1"}}, test::costly_request(5000, 8));
    });
    EXPECT_EQ(slow.status, 202);
    EXPECT_GE(seconds, 1.0);
    EXPECT_LT(seconds, 25.0) << "as if 30 s had been wanted";
    service.post(path_of(slow.json().at("id")) + ":cancel");
    EXPECT_EQ(
        service.post("/v1/bakes", {{"Prefer", "respond-async, wait=30"}}, test::net_request(1))
            .status,
        201);
    for (const char* none :
         {"wait", "wait=", "wait=-1", "wait=1.5", "await=30", "x,,=", "wait=x,"}) {
        EXPECT_EQ(
            service.post("/v1/bakes", {{"Prefer", none}}, test::costly_request(500, 8)).status, 202)
            << none;
    }
}

TEST(ApiWaiting, ASubmissionThatIsForgottenAtOnceIsAnsweredAllTheSame) {
    RunningService service(
        [](ServiceOptions& options) { options.jobs.keep_time = std::chrono::seconds(0); });
    for (int i = 0; i < 8; ++i) {
        const Answer taken =
            service.post("/v1/bakes", {{"Prefer", "wait=30"}}, test::net_request(1));
        EXPECT_TRUE(taken.status == 201 || taken.status == 202) << taken.body;
        EXPECT_TRUE(taken.json().contains("id"));
    }
}

TEST(ApiWaiting, NobodyWaitsForLongerThanThirtySeconds) {
    const auto seconds = [](const std::string& prefer) {
        httplib::Request request;
        request.set_header("Prefer", prefer);
        const auto time = read_wait(request);
        return time ? time->count() : -1;
    };
    EXPECT_EQ(seconds("wait=0"), 0);
    EXPECT_EQ(seconds("wait=29"), 29);
    EXPECT_EQ(seconds("wait=30"), 30);
    EXPECT_EQ(seconds("wait=31"), 30);
    EXPECT_EQ(seconds("respond-async, wait=3600"), 30);
    EXPECT_EQ(seconds("wait=18446744073709551615"), 30);
    EXPECT_EQ(seconds("wait=-1"), -1);
    EXPECT_EQ(seconds("respond-async"), -1);
}

TEST(ApiWaiting, AStatusHasATagAndMayBeWaitedFor) {
    RunningService service;
    const std::string id = service.bake(test::net_request(1));
    const Answer ended = service.get(path_of(id));
    const std::string etag = ended.header("ETag");
    ASSERT_EQ(etag.substr(0, 3), "W/\"") << "seconds go on under it";
    EXPECT_EQ(service.get(path_of(id), {{"If-None-Match", etag}}).status, 304);
    EXPECT_EQ(service.get(path_of(id), {{"If-None-Match", etag.substr(2)}}).status, 304)
        << "weakly compared";
    // A job that has ended does not keep anybody waiting.
    EXPECT_LT(test::seconds_of([&] {
                  service.get(path_of(id), {{"If-None-Match", etag}, {"Prefer", "wait=30"}});
              }),
              25.0);
    service.restart();
    EXPECT_EQ(service.get(path_of(id), {{"If-None-Match", etag}}).status, 200)
        << "a tag of an earlier run";

    const std::string running = service.submit(test::costly_request(5000, 8));
    Answer now = service.get(path_of(running));
    int changes = 0;
    for (int i = 0; i < 50 && changes < 5; ++i) {
        Answer next;
        const double seconds = test::seconds_of([&] {
            next = service.get(path_of(running),
                               {{"If-None-Match", now.header("ETag")}, {"Prefer", "wait=5"}});
        });
        if (next.status == 304) {  // a probe may take long on a busy machine
            EXPECT_GE(seconds, 5.0);
            continue;
        }
        ASSERT_EQ(next.status, 200);
        EXPECT_NE(next.header("ETag"), now.header("ETag"));
        now = next;
        ++changes;
    }
    EXPECT_EQ(changes, 5);
    service.post(path_of(running) + ":cancel");
}

TEST(ApiWaiting, EventsEndWithTheJobAndGoOnWhereTheyBrokeOff) {
    RunningService service([](ServiceOptions& options) { options.jobs.max_running = 1; });
    const std::string before = service.submit(test::costly_request(5000, 8));
    const std::string id = service.submit(test::net_request(6, 16));
    const std::string all = follow(service, id, [&] { service.post(path_of(before) + ":cancel"); });
    EXPECT_NE(all.find("event: status\nid: "), std::string::npos) << all;
    EXPECT_NE(all.find("\"state\":\"QUEUED\""), std::string::npos) << all;
    const size_t end = all.find("event: end\nid: ");
    ASSERT_NE(end, std::string::npos) << all;
    EXPECT_NE(all.find("\"state\":\"SUCCEEDED\"", end), std::string::npos) << all;
    const Answer again = service.get(path_of(id) + "/events", {{"Last-Event-ID", last_id(all)}});
    EXPECT_EQ(again.status, 200);
    EXPECT_EQ(again.header("Content-Type"), "text/event-stream");
    EXPECT_EQ(again.body.find("event:"), std::string::npos) << "all of it was seen";
    const Answer missed = service.get(path_of(id) + "/events", {{"Last-Event-ID", "x.1"}});
    EXPECT_NE(missed.body.find("event: end"), std::string::npos);
}

TEST(ApiWaiting, EventsThatHaveNothingToSayHaveAComment) {
    RunningService service([](ServiceOptions& options) {
        options.jobs.max_running = 1;
        options.comment_interval = std::chrono::milliseconds(200);
    });
    const std::string running = service.submit(test::costly_request(5000, 8));
    const std::string id = service.submit(test::net_request(1));
    std::jthread end([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(1500));
        service.post(path_of(id) + ":cancel");
    });
    const std::string body = service.get(path_of(id) + "/events").body;
    size_t comments = 0;
    for (size_t at = 0; (at = body.find("\n: ", at)) != std::string::npos; ++at) ++comments;
    EXPECT_GE(comments, 2U) << body;
    EXPECT_LE(comments, 8U) << body;
    EXPECT_NE(body.find("event: end"), std::string::npos);
    service.post(path_of(running) + ":cancel");
}

TEST(ApiWaiting, EventsEndAfterTheirTimeHoweverSilent) {
    RunningService service([](ServiceOptions& options) {
        options.jobs.max_running = 1;
        options.comment_interval = std::chrono::seconds(60);
        options.events_time = std::chrono::milliseconds(700);
    });
    service.submit(test::costly_request(5000, 8));
    const std::string id = service.submit(test::net_request(1));
    std::string body;
    EXPECT_LT(test::seconds_of([&] { body = service.get(path_of(id) + "/events").body; }), 20.0);
    EXPECT_NE(body.find("event: status"), std::string::npos) << body;
    EXPECT_EQ(body.find("event: end"), std::string::npos) << body;
}

// A client of HTTP/1.0 takes what comes until the connection ends.
TEST(ApiWaiting, StreamsHaveNoChunksInHttp10) {
    RunningService service;
    const std::string id = service.bake(test::net_request(1));
    for (const char* stream : {"/events", "/archive.tar"}) {
        const auto answer = [&](const std::string& version) {
            return test::exchange(service.port(), "GET " + path_of(id) + stream + " HTTP/" +
                                                      version + "\r\nHost: localhost\r\n\r\n");
        };
        const std::string old = answer("1.0");
        EXPECT_EQ(test::status_of(old), 200);
        EXPECT_EQ(old.find("Transfer-Encoding"), std::string::npos) << stream;
        EXPECT_EQ(old.find("Content-Length"), std::string::npos) << stream;
        EXPECT_EQ(old.substr(old.find("\r\n\r\n") + 4), service.get(path_of(id) + stream).body);
        EXPECT_NE(answer("1.1").find("Transfer-Encoding: chunked"), std::string::npos) << stream;
    }
}

TEST(ApiWaiting, WaitersLeaveHalfOfTheThreadsAlone) {
    RunningService service([](ServiceOptions& options) { options.http.pool.workers = 4; });
    const std::string id = service.submit(test::costly_request(5000, 16));
    std::atomic<int> waiting{0};
    std::vector<std::jthread> waiters;
    waiters.reserve(2);
    for (int i = 0; i < 2; ++i) {
        waiters.emplace_back([&] { follow(service, id, [&] { ++waiting; }); });
    }
    for (int i = 0; i < 60000 && waiting < 2; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const Answer refused = service.get(path_of(id) + "/events");
    EXPECT_EQ(refused.status, 503);
    EXPECT_EQ(refused.json().at("type"), "urn:probebake:too-many-waiting");
    EXPECT_EQ(service.get("/healthz").status, 200);
    service.post(path_of(id) + ":cancel");
}

TEST(Ranges, AreReadAsRfc9110HasThem) {
    const auto read = [](const char* text) {
        const auto range = read_range(text, 100);
        return range ? std::to_string(range->first) + "+" + std::to_string(range->bytes)
                     : std::string("none");
    };
    EXPECT_EQ(read("bytes=0-9"), "0+10");
    EXPECT_EQ(read("bytes=90-"), "90+10");
    EXPECT_EQ(read("bytes=90-1000"), "90+10");
    EXPECT_EQ(read("bytes=-5"), "95+5");
    EXPECT_EQ(read("bytes=-500"), "0+100");
    EXPECT_EQ(read("bytes=-0"), "100+0");
    EXPECT_EQ(read("bytes=100-"), "100+0");
    EXPECT_EQ(read("bytes=18446744073709551615-18446744073709551615"), "18446744073709551615+0");
    for (const char* bad :
         {"", "bytes", "bytes=", "bytes=-", "bytes=5-4", "bytes=a-b", "bytes=1", "chunks=0-1",
          "bytes=0-1,2-3", "bytes= 0-1", "bytes=--1", "bytes=99999999999999999999-"}) {
        EXPECT_EQ(read(bad), "none") << bad;
    }
}

TEST(ApiFiles, DigestsAreThoseOfRfc9530) {
    // Of "hello" and a line feed, as openssl and base64 have it.
    EXPECT_EQ(repr_digest(sha256_hex(std::as_bytes(std::span("hello\n", 6)))),
              "sha-256=:WJG1tSLV3whtD/CxEPvZ0hu0/HFjrzTQgoai6Eb2vgM=:");
}

TEST(ApiFiles, APartOfAFileIsAnswered) {
    RunningService service;
    const std::string id = service.bake(test::net_request(1));
    const std::string file = path_of(id) + "/probes/p0/albedo/cube.exr";
    const Answer whole = service.get(file);
    EXPECT_EQ(whole.header("Repr-Digest"),
              repr_digest(sha256_hex(std::as_bytes(std::span(whole.body)))));
    const Answer part = service.get(file, {{"Range", "bytes=10-19"}});
    EXPECT_EQ(part.status, 206);
    EXPECT_EQ(part.body, whole.body.substr(10, 10));
    EXPECT_EQ(part.header("Content-Range"), "bytes 10-19/" + std::to_string(whole.body.size()));
    EXPECT_EQ(part.header("Content-Length"), "10");
    EXPECT_EQ(part.header("Repr-Digest"), whole.header("Repr-Digest")) << "of the whole";
    EXPECT_EQ(service.get(file, {{"Range", "bytes=-4"}}).body,
              whole.body.substr(whole.body.size() - 4));
    const Answer beyond = service.get(file, {{"Range", "bytes=99999999-"}});
    EXPECT_EQ(beyond.status, 416);
    EXPECT_EQ(beyond.header("Content-Range"), "bytes */" + std::to_string(whole.body.size()));
    // Several are answered as none; and a part of another version would be of no use.
    EXPECT_EQ(service.get(file, {{"Range", "bytes=0-1,4-5"}}).body, whole.body);
    EXPECT_EQ(service.get(file, {{"Range", "bytes=0-1"}, {"If-Range", "\"x\""}}).status, 200);
    EXPECT_EQ(
        service.get(file, {{"Range", "bytes=0-1"}, {"If-Range", whole.header("ETag")}}).status,
        206);
    EXPECT_EQ(service.client().Head(file, {{"Range", "bytes=0-1"}})->status, 200) << "GET only";
}

TEST(ApiFiles, AnArchiveHoldsEveryFile) {
    RunningService service;
    const std::string id = service.bake(test::net_request(3));
    const Answer tar = service.get(path_of(id) + "/archive.tar");
    ASSERT_EQ(tar.status, 200);
    EXPECT_EQ(tar.header("Content-Type"), "application/x-tar");
    const test::TempFolder folder;
    test::write_text(folder.path() / "a.tar", tar.body);
    const std::string command =
        "tar -xf " + (folder.path() / "a.tar").string() + " -C " + folder.path().string();
    ASSERT_EQ(std::system(command.c_str()), 0);
    const Json manifest = parse_json(test::read_text(folder.path() / id / "manifest.json"));
    EXPECT_EQ(manifest.at("files").size(), 4U);
    for (const Json& file : manifest.at("files")) {
        const std::string bytes =
            test::read_text(folder.path() / id / file.at("name").get<std::string>());
        EXPECT_EQ(bytes.size(), file.at("bytes"));
        EXPECT_EQ(sha256_hex(std::as_bytes(std::span(bytes))), file.at("sha256"));
    }
    const std::string running = service.submit(test::costly_request(5000, 8));
    EXPECT_EQ(service.get(path_of(running) + "/archive.tar").status, 409);
}

TEST(ApiFiles, AnArchiveHealsWhatItFindsDamaged) {
    RunningService service;
    const std::string id = service.bake(test::net_request(3));
    const std::string path = path_of(id) + "/archive.tar";
    const std::string whole = service.get(path).body;
    const std::string tag = service.get(path_of(id) + "/probes/p1/albedo/cube.exr").header("ETag");
    const std::string digest = tag.substr(1, 64);
    const std::filesystem::path file =
        service.options().data / "files" / digest.substr(0, 2) / digest;
    std::string bytes = test::read_text(file);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    test::write_text(file, bytes);
    EXPECT_FALSE(service.client().Get(path)) << "an archive without an end";
    httplib::Result again = service.client().Get(path);
    for (int i = 0; i < 6000 && !again; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        again = service.client().Get(path);
    }
    ASSERT_TRUE(again);
    EXPECT_EQ(again->body, whole);
    EXPECT_EQ(service.state(id), "SUCCEEDED");
    // The file is whole a little before the mend is told of.
    const auto told = [&] {
        const std::string metrics = service.get("/metrics").body;
        return metrics.find("damaged_units_total{result=\"mended\"} 1") != std::string::npos;
    };
    for (int i = 0; i < 6000 && !told(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_TRUE(told());
}

TEST(ApiFiles, AnArchiveWithoutItsReportIsGone) {
    RunningService service;
    const std::string id = service.bake(test::net_request(1));
    const std::string report = service.get(path_of(id) + "/report").body;
    const std::string digest = sha256_hex(std::as_bytes(std::span(report)));
    test::write_text(service.options().data / "files" / digest.substr(0, 2) / digest, "{}");
    const Answer gone = service.get(path_of(id) + "/archive.tar");
    EXPECT_EQ(gone.status, 410);
    EXPECT_EQ(gone.json().at("type"), "urn:probebake:damaged");
}

TEST(ApiRetention, AFinishedJobCanBeDeleted) {
    RunningService service;
    const std::string id = service.bake(test::net_request(1));
    EXPECT_EQ(service.remove(path_of(id) + "?dry_run=true").status, 204);
    EXPECT_EQ(service.get(path_of(id)).status, 200);
    EXPECT_EQ(service.remove(path_of(id) + "?dry_run=maybe").status, 400);
    EXPECT_EQ(service.remove(path_of(id)).status, 204);
    EXPECT_EQ(service.get(path_of(id)).status, 404);
    EXPECT_EQ(service.remove(path_of(id)).status, 404);
    const std::string running = service.submit(test::costly_request(5000, 8));
    EXPECT_EQ(service.remove(path_of(running)).status, 409);
    const Json expired = service.post("/v1/bakes:expire?dry_run=true").json();
    EXPECT_EQ(expired.at("bakes").size(), 0U);
}

TEST(ApiAbout, MetricsAndReadiness) {
    RunningService service;
    const std::string id = service.bake(test::net_request(2));
    const Answer metrics = service.get("/metrics");
    ASSERT_EQ(metrics.status, 200);
    for (const char* line :
         {"probebake_jobs{state=\"SUCCEEDED\"} 1", "probebake_units_total 2",
          "probebake_http_requests_total{method=\"POST\",status=\"202\"} 1",
          "probebake_jobs_ended_total{state=\"SUCCEEDED\"} 1",
          "probebake_media_collisions_total{kind=\"null\"} 0", "probebake_path_faults_total 0",
          "probebake_error_over_target_count{metric=\"psnr_db\"} 1",
          "probebake_http_request_seconds_bucket", "probebake_job_queue_seconds_count 1",
          "probebake_job_seconds_count 1", "probebake_jobs{state=\"QUEUED\"} 0",
          "probebake_store_commits_total", "probebake_store_commit_seconds_total",
          "probebake_recovered_units_total 0", "probebake_poisoned_units_total 0",
          "probebake_promised_bytes 0", "probebake_disk_free_bytes"}) {
        EXPECT_NE(metrics.body.find(line), std::string::npos) << line << "\n" << metrics.body;
    }
    const auto value = [&](const std::string& name) {
        const size_t at = metrics.body.find("\n" + name + " ");
        return at == std::string::npos ? -1.0
                                       : std::stod(metrics.body.substr(at + name.size() + 2));
    };
    const Json totals = service.get(path_of(id) + "/report").json().at("totals");
    EXPECT_EQ(value("probebake_artifact_bytes_total"), totals.at("bytes"));
    EXPECT_GT(value("probebake_rays_total"), 2 * 6 * 7 * 7);
    EXPECT_GT(value("probebake_octree_steps_total"), value("probebake_rays_total"));
    EXPECT_EQ(service.get("/readyz").json().at("ready"), true);
    std::filesystem::rename(service.options().data / "probebake.sqlite",
                            service.options().data / "elsewhere");
    EXPECT_EQ(service.get("/readyz").status, 503) << "the database is gone";
    EXPECT_EQ(service.get("/readyz").json().at("database_writable"), false);
    RunningService full(
        [](ServiceOptions& options) { options.store.min_free_bytes = ~uint64_t{0}; });
    EXPECT_EQ(full.get("/readyz").status, 503);
    const Answer refused = full.post("/v1/bakes", test::net_request(1));
    EXPECT_EQ(refused.status, 503);
    EXPECT_EQ(refused.json().at("type"), "urn:probebake:disk-full");
}

TEST(ApiAbout, EveryRouteIsDescribed) {
    const test::OpenApiCheck check;
    EXPECT_EQ(check.operations(), Api::route_names().size());
    for (const auto& [method, pattern] : Api::route_names()) {
        EXPECT_TRUE(check.describes(method, pattern)) << method << " " << pattern;
    }
}

}  // namespace
}  // namespace probebake
