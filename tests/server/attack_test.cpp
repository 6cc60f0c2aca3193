// Clients that mean harm. What the HTTP library does with each of these by itself stands in
// docs/service.md; here the guards hold.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <stdexcept>

#include "raw_client.h"
#include "running_service.h"
#include "support/sanitized.h"

namespace probebake {
namespace {

using test::RawClient;
using test::RunningService;
using test::status_of;
using namespace std::chrono_literals;

constexpr const char* kHost = "Host: 127.0.0.1\r\n";
constexpr const char* kJson = "Content-Type: application/json\r\n";

std::string request(const std::string& line, const std::string& headers = {},
                    const std::string& body = {}) {
    return line + " HTTP/1.1\r\n" + kHost + headers + "\r\n" + body;
}

/// What comes back for these bytes; a refusal is one as openapi.json describes them.
std::string exchange(int port, std::string_view bytes) {
    static const test::OpenApiCheck api;
    std::string answer = test::exchange(port, bytes);
    const size_t blank = answer.find("\r\n\r\n");
    if (status_of(answer) >= 400 && blank + 4 < answer.size()) {
        EXPECT_LT(answer.find("Content-Type: application/problem+json"), blank) << answer;
        const Json body = parse_json(answer.substr(blank + 4));
        for (const std::string& problem : api.schema_problems("Problem", body)) {
            ADD_FAILURE() << problem << " in " << answer;
        }
    }
    return answer;
}

uint64_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    uint64_t total = 0;
    uint64_t resident = 0;
    file >> total >> resident;
    return resident * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Whether the service still answers, and quickly.
void expect_well(const RunningService& service) {
    EXPECT_LT(test::seconds_of([&] { EXPECT_EQ(service.get("/healthz").status, 200); }),
              test::patient(1.0));
}

TEST(Attack, ChunkedBodiesAreRefusedUnread) {
    const RunningService service;
    const uint64_t before = resident_bytes();
    RawClient client(service.port());
    client.send(request("POST /v1/bakes", std::string(kJson) + "Transfer-Encoding: chunked\r\n"));
    const std::string chunk = "10000\r\n" + std::string(0x10000, 'x') + "\r\n";
    uint64_t sent = 0;
    while (sent < (uint64_t{300} << 20) && client.send(chunk)) sent += chunk.size();
    EXPECT_LT(resident_bytes(), before + (uint64_t{16} << 20));
    EXPECT_EQ(status_of(exchange(
                  service.port(),
                  request("POST /v1/bakes", std::string(kJson) + "Transfer-Encoding: chunked\r\n",
                          "5\r\nabcde\r\n0\r\n\r\n"))),
              411);
    expect_well(service);
}

TEST(Attack, CompressedBodiesAreRefused) {
    const RunningService service;
    for (const char* encoding : {"gzip", "deflate", "br", "identity", "x"}) {
        const std::string headers =
            std::string(kJson) + "Content-Encoding: " + encoding + "\r\nContent-Length: 4\r\n";
        EXPECT_EQ(status_of(exchange(service.port(), request("POST /v1/bakes", headers, "abcd"))),
                  415);
    }
}

TEST(Attack, LargeBodiesAreRefusedAndTheRefusalArrives) {
    const RunningService service;
    const std::string body(5 << 20, ' ');
    const std::string headers =
        std::string(kJson) + "Content-Length: " + std::to_string(body.size()) + "\r\n";
    // The client sends all of it before it looks: the answer must not be lost to a reset.
    for (int i = 0; i < 5; ++i) {
        const std::string answer =
            exchange(service.port(), request("POST /v1/bakes", headers, body));
        EXPECT_EQ(status_of(answer), 413);
    }
    const std::string expecting = headers + "Expect: 100-continue\r\n";
    EXPECT_EQ(status_of(exchange(service.port(), request("POST /v1/bakes", expecting))), 413)
        << "nobody needs to send a body that is not wanted";
}

TEST(Attack, AnExpectedContinueComesBeforeTheAnswer) {
    const RunningService service;
    const std::string body = test::net_request(1).dump();
    RawClient client(service.port());
    client.send(request("POST /v1/bakes:check", std::string(kJson) +
                                                    "Expect: 100-continue\r\nContent-Length: " +
                                                    std::to_string(body.size()) + "\r\n"));
    EXPECT_EQ(status_of(client.read_some(100)), 100);
    client.send(body);
    EXPECT_EQ(status_of(client.read_all()), 200);
}

TEST(Attack, HeadersAreBounded) {
    const RunningService service;
    const uint64_t before = resident_bytes();
    std::string many = "GET /healthz HTTP/1.1\r\n" + std::string(kHost);
    for (int i = 0; i < 100'000; ++i) many += "X-" + std::to_string(i) + ": y\r\n";
    EXPECT_EQ(status_of(exchange(service.port(), many + "\r\n")), 431);

    RawClient endless(service.port());
    endless.send("GET /healthz HTTP/1.1\r\nX: ");
    const std::string piece(1 << 20, 'a');
    for (int i = 0; i < 200 && endless.send(piece); ++i) {
    }
    EXPECT_EQ(status_of(exchange(service.port(), "GET /" + std::string(200'000, 'a'))), 431);
    EXPECT_EQ(status_of(exchange(service.port(), request("GET /" + std::string(5000, 'a')))), 414);
    EXPECT_LT(resident_bytes(), before + (uint64_t{16} << 20));
    expect_well(service);
}

TEST(Attack, NothingIsTakenForASecondRequest) {
    RunningService service;
    const std::string id = service.submit(test::costly_request(5000, 8));
    // The request that an attacker would like to slip through, as the body of another.
    const std::string hidden = request("POST /v1/bakes/" + id + ":cancel");
    service.wait(id, [](const Json& bake) { return bake["state"] == "RUNNING"; });
    const std::string length = "Content-Length: " + std::to_string(hidden.size()) + "\r\n";
    const std::vector<std::pair<std::string, int>> smuggled = {
        {request("GET /healthz", length, hidden), 400},
        {request("HEAD /healthz", length, hidden), 400},
        {request("GET /healthz", "Transfer-Encoding: chunked\r\n", "0\r\n\r\n" + hidden), 411},
        {request("POST /v1/bakes", std::string(kJson) + "Transfer-Encoding: chunked\r\n" + length,
                 "0\r\n\r\n" + hidden),
         411},
        {request("POST /v1/bakes", std::string(kJson) + "Content-Length: 5000000\r\n", hidden),
         413},
        {request("POST /v1/bakes", length, hidden), 415},
        {request("POST /v1/bakes", std::string(kJson) + "Content-Length: 0\r\n" + length, hidden),
         400},
        {request("POST /v1/bakes", std::string(kJson) + "Content-Length: 2\r\n", "{}" + hidden),
         400},
        {request("GET /healthz", "Connection: keep-alive\r\n") + hidden, 200},
        {request("GET /nowhere") + hidden, 404},
        {request("POST /v1/bakes/" + id + ":cancle") + hidden, 404},
    };
    for (const auto& [bytes, expected] : smuggled) {
        const std::string answer = exchange(service.port(), bytes);
        EXPECT_EQ(status_of(answer), expected) << bytes.substr(0, 200);
        EXPECT_EQ(test::answers_in(answer), 1U) << bytes.substr(0, 200);
        EXPECT_NE(answer.find("Connection: close"), std::string::npos);
    }
    EXPECT_EQ(service.state(id), "RUNNING") << "a hidden request came through";
    service.post("/v1/bakes/" + id + ":cancel");
}

TEST(Attack, RangesAreIgnored) {
    RunningService service;
    const std::string id = service.bake(test::net_request(1, 64));
    const std::string path = "/v1/bakes/" + id + "/probes/p0/albedo/cube.exr";
    const std::string whole = service.get(path).body;
    const uint64_t before = resident_bytes();
    std::string overlapping = "bytes=0-";
    for (int i = 0; i < 1300; ++i) overlapping += ",0-" + std::to_string(i);
    for (const std::string& range :
         {std::string("bytes=0-3"), std::string("bytes=0-99999999"), std::string("bytes=-100000"),
          std::string("bytes=99999999999999999999-"), std::string("bytes=5-2"),
          std::string("nonsense"), overlapping}) {
        const test::Answer answer = service.get(path, {{"Range", range}, {"If-Range", "\"x\""}});
        EXPECT_EQ(answer.status, 200) << range.substr(0, 50);
        EXPECT_EQ(answer.body, whole) << range.substr(0, 50);
        EXPECT_EQ(answer.header("Content-Length"), std::to_string(whole.size()));
        EXPECT_EQ(answer.headers.count("Content-Range"), 0U);
    }
    EXPECT_EQ(service.get("/healthz", {{"Range", "bytes=0-100000000"}}).status, 200);
    EXPECT_EQ(service.get("/nowhere", {{"Range", "bytes=0-3"}}).json().at("status"), 404);
    EXPECT_LT(resident_bytes(), before + (uint64_t{16} << 20));
}

TEST(Attack, ForeignHostsAreRefused) {
    const RunningService service;
    EXPECT_EQ(
        status_of(exchange(service.port(), "GET /v1/bakes HTTP/1.1\r\nHost: evil.example\r\n\r\n")),
        421);
    EXPECT_EQ(status_of(exchange(service.port(), "GET /v1/bakes HTTP/1.1\r\n\r\n")), 400);
}

TEST(Attack, AnswersCarryNothingOfTheClients) {
    const RunningService service;
    const std::string answer = exchange(
        service.port(), request("GET /nowhere%0d%0aSet-Cookie:%20a=b?x=%0d%0ay",
                                "X-Request-Id: a%0d%0aSet-Cookie: b\r\nReferer: %0d%0aX: y\r\n"));
    EXPECT_EQ(status_of(answer), 404);
    EXPECT_EQ(answer.find("Set-Cookie"), std::string::npos);
    EXPECT_EQ(answer.find("X-Request-Id: a"), std::string::npos);
    EXPECT_EQ(answer.find("127.0.0.1"), std::string::npos);
}

TEST(Attack, TheTextOfAnExceptionStaysHere) {
    std::mutex mutex;
    std::vector<RequestLog> log;
    HttpServer::Options options;
    options.port = 0;
    const HttpServer server(
        options,
        [](const httplib::Request& request, httplib::Response&, const httplib::ContentReader*) {
            if (request.path == "/odd") throw 42;  // no std::exception at all
            throw std::runtime_error("secret\r\nSet-Cookie: a");
        },
        [&](const RequestLog& line) {
            const std::lock_guard lock(mutex);
            log.push_back(line);
        });
    for (const char* path : {"/", "/odd"}) {
        const std::string answer = exchange(server.port(), request("GET " + std::string(path)));
        EXPECT_EQ(status_of(answer), 500);
        EXPECT_EQ(answer.find("secret"), std::string::npos) << answer;
        EXPECT_EQ(answer.find("EXCEPTION"), std::string::npos) << answer;
        EXPECT_NE(answer.find("X-Request-Id: r-"), std::string::npos);
        EXPECT_NE(answer.find("urn:probebake:internal"), std::string::npos);
    }
    const std::lock_guard lock(mutex);
    const bool logged = std::any_of(log.begin(), log.end(), [](const RequestLog& line) {
        return line.cause.find("secret") != std::string::npos;
    });
    EXPECT_TRUE(logged) << "the log knows the cause";
}

TEST(Attack, ClientsThatDripAreCutOff) {
    const RunningService service([](ServiceOptions& options) {
        options.http.connection.head_time = 300ms;
        options.http.connection.body_time = 300ms;
    });
    RawClient idle(service.port());
    RawClient half(service.port());
    half.send("GET /healthz HTT");
    RawClient body(service.port());
    body.send(request("POST /v1/bakes", std::string(kJson) + "Content-Length: 100\r\n", "{"));
    RawClient drip(service.port());
    const double seconds = test::seconds_of([&] {
        // Every byte in time, the whole head never.
        for (int i = 0; i < 100 && drip.send("G"); ++i) std::this_thread::sleep_for(10ms);
        EXPECT_EQ(status_of(drip.read_all()), 408);
    });
    EXPECT_LT(seconds, test::patient(3.0));
    EXPECT_EQ(idle.read_all(), "");
    EXPECT_EQ(status_of(half.read_all()), 408);
    EXPECT_EQ(status_of(body.read_all()), 400);
}

TEST(Attack, ClientsThatDoNotReadAreCutOff) {
    constexpr size_t kBytes = size_t{64} << 20;  // more than the buffers of the sockets take
    constexpr uint64_t kLeastRate = (uint64_t{16} << 20) / test::patient(uint64_t{1});
    HttpServer::Options options;
    options.port = 0;
    options.pool.workers = 1;
    options.connection.answer_time = 300ms;
    options.connection.min_answer_bytes_per_second = kLeastRate;
    const HttpServer server(
        options,
        [](const httplib::Request& request, httplib::Response& response,
           const httplib::ContentReader*) {
            if (request.path != "/large") return response.set_content("ok", "text/plain");
            response.set_content_provider(
                kBytes, "text/plain", [](size_t, size_t length, httplib::DataSink& sink) {
                    const std::string piece(std::min<size_t>(length, 65536), 'x');
                    return sink.write(piece.data(), piece.size());
                });
        },
        [](const RequestLog&) {});
    RawClient deaf(server.port());
    deaf.send(request("GET /large"));
    std::this_thread::sleep_for(50ms);
    // The only worker is held by the deaf client, but not for longer than it may.
    const double seconds = test::seconds_of(
        [&] { EXPECT_EQ(status_of(exchange(server.port(), request("GET /small"))), 200); });
    EXPECT_GT(seconds, 0.2) << "the deaf client held nobody up: the test shows nothing";
    EXPECT_LT(seconds, test::patient(2.0));
    EXPECT_LT(deaf.read_all().size(), kBytes);
    // Who reads gets everything; a machine that is slower than the least rate itself shows nothing.
    size_t got = 0;
    const double reading =
        test::seconds_of([&] { got = exchange(server.port(), request("GET /large")).size(); });
    const bool slow = test::thread_sanitized() && static_cast<double>(got) < kLeastRate * reading;
    EXPECT_TRUE(got > kBytes || slow) << got << " bytes in " << reading << " s";
}

TEST(Attack, IdleConnectionsBlockOthersForABoundedTimeOnly) {
    const RunningService service([](ServiceOptions& options) {
        options.http.connection.head_time = 500ms;
        options.http.pool = {.workers = 4, .max_waiting = 8, .max_refusals_waiting = 4};
    });
    std::vector<RawClient> idle;
    idle.reserve(4);
    for (int i = 0; i < 4; ++i) idle.emplace_back(service.port());
    std::this_thread::sleep_for(50ms);
    idle.reserve(8);
    for (int i = 0; i < 8; ++i) idle.emplace_back(service.port());
    std::this_thread::sleep_for(50ms);
    // Four are served and eight wait: whoever comes now is told so at once.
    const double seconds = test::seconds_of([&] {
        const std::string answer = exchange(service.port(), request("GET /healthz"));
        EXPECT_EQ(status_of(answer), 503);
        EXPECT_NE(answer.find("Retry-After: "), std::string::npos);
        EXPECT_NE(answer.find("urn:probebake:too-many-connections"), std::string::npos);
    });
    EXPECT_LT(seconds, test::patient(0.45));
    // (waiting / workers + 1) × head_time, and they are all gone.
    std::this_thread::sleep_for(1600ms);
    expect_well(service);
    for (RawClient& client : idle) EXPECT_EQ(client.read_all(), "");
}

TEST(Attack, AFloodOfConnectionsIsShed) {
    const RunningService service([](ServiceOptions& options) {
        options.http.connection.head_time = 200ms;
        options.http.pool = {.workers = 2, .max_waiting = 4, .max_refusals_waiting = 4};
    });
    std::vector<RawClient> flood;
    flood.reserve(300);
    for (int i = 0; i < 300; ++i) flood.emplace_back(service.port());
    size_t told = 0;
    for (RawClient& client : flood) told += status_of(client.read_all()) == 503 ? 1 : 0;
    EXPECT_GT(told, 0U);
    expect_well(service);
}

TEST(Attack, GarbageIsAnsweredOrDropped) {
    const RunningService service;
    std::string zeros(5000, '\0');
    for (const std::string& bytes :
         {std::string("\r\n\r\n"), zeros + "\r\n\r\n", std::string("GET\r\n\r\n"),
          std::string("\x16\x03\x01\x02\x00\x01\r\n\r\n", 10),
          std::string("PRI * HTTP/2.0\r\n\r\n"),
          std::string("GET / HTTP/9.9\r\nHost: 127.0.0.1\r\n\r\n")}) {
        EXPECT_EQ(status_of(exchange(service.port(), bytes)), 400);
    }
    expect_well(service);
}

}  // namespace
}  // namespace probebake
