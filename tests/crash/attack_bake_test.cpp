// C14: the attacks of docs/service.md, all at once, while the service bakes; against the service
// alone and behind the proxy.
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <mutex>
#include <set>

#include "crash_fixture.h"
#include "server/raw_client.h"
#include "service_process.h"

namespace probebake {
namespace {

using test::RawClient;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

const std::string kHost = "Host: 127.0.0.1\r\n";
const std::string kJson = "Content-Type: application/json\r\n";
constexpr auto kPatience = 2s;

std::string head(const std::string& line, const std::string& headers = {}) {
    return line + " HTTP/1.1\r\n" + kHost + "Connection: close\r\n" + headers + "\r\n";
}

/// A file of the service, and what it holds.
struct KnownFile {
    std::string target;
    std::string bytes;
};

/// What the attackers share.
struct Battle {
    int port = 0;
    bool behind_proxy = false;
    KnownFile file;
    std::string victim;  // a running bake that nobody may cancel

    std::mutex mutex = {};
    std::set<std::string> wounds = {};  // what must not be
    std::atomic<uint64_t> blows{0};

    void require(bool holds, const std::string& what) {
        if (holds) return;
        const std::lock_guard lock(mutex);
        wounds.insert(what);
    }
};

using Attack = std::function<void(Battle&, const std::stop_token&, uint32_t from)>;

/// Sends, reads, and looks at what comes: nothing, or one whole answer of ours. Its body.
std::string strike(Battle& battle, uint32_t from, const std::string& bytes) {
    ++battle.blows;
    RawClient client(battle.port, from);
    client.send(bytes);
    std::string answer = client.read_all(kPatience);
    if (answer.empty()) return "";
    const size_t blank = answer.find("\r\n\r\n");
    battle.require(test::status_of(answer) >= 200 && blank != std::string::npos,
                   "no HTTP: " + answer.substr(0, 80));
    battle.require(test::answers_in(answer) <= 1, "several answers to " + bytes.substr(0, 60));
    const size_t length = answer.find("Content-Length: ");
    if (length < blank) {
        // Not more than was announced: what follows a body is foreign. (Less where it broke off.)
        battle.require(answer.size() - blank - 4 <= std::stoull(answer.substr(length + 16)),
                       "more bytes than announced");
    }
    return answer;
}

void hold_idle_connections(Battle& battle, const std::stop_token& stop, uint32_t from) {
    const int count = test::form("PROBEBAKE_ATTACK_IDLE", 250);
    while (!stop.stop_requested()) {
        std::vector<RawClient> idle;
        idle.reserve(static_cast<size_t>(count));
        for (int i = 0; i < count && !stop.stop_requested(); ++i)
            idle.emplace_back(battle.port, from);
        battle.blows += idle.size();
        for (int i = 0; i < 10 && !stop.stop_requested(); ++i) std::this_thread::sleep_for(100ms);
    }
}

void drip(Battle& battle, const std::stop_token& stop, uint32_t from) {
    while (!stop.stop_requested()) {
        std::vector<RawClient> slow;
        slow.reserve(40);
        for (int i = 0; i < 40; ++i) slow.emplace_back(battle.port, from);
        const std::string bytes = head("POST /v1/bakes", kJson + "Content-Length: 1000\r\n");
        battle.blows += slow.size();
        for (size_t at = 0; at < 40 && !stop.stop_requested(); ++at) {
            for (RawClient& client : slow) client.send(bytes.substr(at, 1));
            std::this_thread::sleep_for(50ms);
        }
    }
}

void do_not_read(Battle& battle, const std::stop_token& stop, uint32_t from) {
    while (!stop.stop_requested()) {
        std::vector<RawClient> deaf;
        deaf.reserve(24);
        for (int i = 0; i < 24; ++i) {
            deaf.emplace_back(battle.port, from).send(head("GET " + battle.file.target));
        }
        battle.blows += deaf.size();
        for (int i = 0; i < 10 && !stop.stop_requested(); ++i) std::this_thread::sleep_for(100ms);
    }
}

void send_large_bodies(Battle& battle, const std::stop_token& stop, uint32_t from) {
    const std::string chunk = "10000\r\n" + std::string(0x10000, 'x') + "\r\n";
    while (!stop.stop_requested()) {
        ++battle.blows;
        RawClient client(battle.port, from);
        client.send(head("POST /v1/bakes", kJson + "Transfer-Encoding: chunked\r\n"));
        for (int i = 0; i < 300 && client.send(chunk); ++i) {
        }
        strike(battle, from, head("POST /v1/bakes", kJson + "Content-Length: 99999999999\r\n"));
        // 509 KiB that would become 512 MiB.
        strike(
            battle, from,
            head("POST /v1/bakes", kJson + "Content-Encoding: gzip\r\nContent-Length: 521000\r\n") +
                std::string(521000, '\x1f'));
        strike(battle, from, head("POST /v1/bakes", kJson + "Content-Length: -1\r\n"));
    }
}

void send_large_heads(Battle& battle, const std::stop_token& stop, uint32_t from) {
    std::string many = "GET /healthz HTTP/1.1\r\n" + kHost;
    for (int i = 0; i < 100'000; ++i) many += "X-" + std::to_string(i) + ": y\r\n";
    const std::string piece(1 << 20, 'a');
    while (!stop.stop_requested()) {
        strike(battle, from, many + "\r\n");
        ++battle.blows;
        RawClient endless(battle.port, from);
        endless.send("GET /healthz HTTP/1.1\r\nX: ");
        for (int i = 0; i < 200 && endless.send(piece); ++i) {
        }
        strike(battle, from, head("GET /" + std::string(100'000, 'a')));
    }
}

void smuggle(Battle& battle, const std::stop_token& stop, uint32_t from) {
    const std::string hidden =
        "POST /v1/bakes/" + battle.victim + ":cancel HTTP/1.1\r\n" + kHost + "\r\n";
    const std::string length = "Content-Length: " + std::to_string(hidden.size()) + "\r\n";
    const std::string chunked = "Transfer-Encoding: chunked\r\n";
    const std::vector<std::string> ways = {
        head("GET /healthz", length) + hidden,
        head("HEAD /healthz", length) + hidden,
        head("GET /healthz", chunked) + "0\r\n\r\n" + hidden,
        head("POST /v1/bakes", kJson + chunked + length) + "0\r\n\r\n" + hidden,
        head("POST /v1/bakes", kJson + "Content-Length: 5000000\r\n") + hidden,
        head("POST /v1/bakes", kJson + "Content-Length: 0\r\n" + length) + hidden,
        head("POST /v1/bakes", kJson + "Content-Length: 2\r\n") + "{}" + hidden,
        head("POST /v1/bakes", kJson + "Transfer-Encoding : chunked\r\n" + length) + hidden,
        head("POST /v1/bakes", kJson + "Content-Length: 2\n" + length) + "{}" + hidden,
    };
    while (!stop.stop_requested()) {
        for (const std::string& way : ways) strike(battle, from, way);
        for (const char* host : {"Host: evil.example\r\n", "", "Host: 127.0.0.1\r\nHost: b\r\n"}) {
            const std::string answer =
                strike(battle, from, "GET /v1/bakes HTTP/1.1\r\n" + std::string(host) + "\r\n");
            battle.require(test::status_of(answer) != 200, "a foreign host was answered");
        }
    }
}

void ask_for_ranges(Battle& battle, const std::stop_token& stop, uint32_t from) {
    std::string overlapping = "bytes=0-";
    for (int i = 0; i < 600; ++i) overlapping += ",0-" + std::to_string(i);
    while (!stop.stop_requested()) {
        for (const std::string& range :
             {overlapping, std::string("bytes=0-100000000"), std::string("bytes=5-2"),
              std::string("bytes=99999999999999999999-"), std::string("bytes=-100000000"),
              std::string("bytes=18446744073709551615-18446744073709551615"),
              std::string("bytes=7-106")}) {
            const std::string answer =
                strike(battle, from, head("GET " + battle.file.target, "Range: " + range + "\r\n"));
            const int status = test::status_of(answer);
            if (status != 200 && status != 206) continue;
            const std::string body = answer.substr(answer.find("\r\n\r\n") + 4);
            battle.require(battle.file.bytes.find(body) != std::string::npos,
                           "foreign bytes in an answer to " + range.substr(0, 40));
        }
        strike(battle, from, head("GET /nowhere%0d%0aX:%20y", "Range: bytes=0-5\r\n"));
    }
}

void send_bad_requests(Battle& battle, const std::stop_token& stop, uint32_t from) {
    const auto post = [&](const std::string& body) {
        return strike(battle, from,
                      head("POST /v1/bakes",
                           kJson + "Content-Length: " + std::to_string(body.size()) + "\r\n") +
                          body);
    };
    std::string many = "[";
    for (int i = 0; i < 200'000; ++i) many += "0,";
    while (!stop.stop_requested()) {
        for (const std::string& body :
             {std::string(200'000, '['), many + "0]", std::string("{\"a\":1e999}"),
              std::string("{\"scene\":\"net\",\"scene\":\"net\"}"), std::string("\xff\xfe{}"),
              std::string(R"({"scene":"net","probes":{"grids":[{"id":"g","origin_m":[0,0,0],)"
                          R"("spacing_m":[1,1,1],"counts":[1000,1000,1000]}]}})"),
              std::string(R"({"scene":"../../etc/passwd","probes":{"list":[{"id":"a",)"
                          R"("position_m":[0,0,0]}]}})"),
              std::string(R"({"scene":"net","face_size_px":1e300,"seed":-1})")}) {
            const int status = test::status_of(post(body));
            battle.require(status == 0 || status >= 400, "a bad request was taken");
            battle.require(status != 500 && status != 502, "a bad request broke something");
        }
    }
}

/// Milliseconds of /healthz, one connection each, and how many had no good answer.
struct Health {
    std::vector<double> milliseconds;
    uint64_t failures = 0;

    double p99() const {
        return milliseconds.empty() ? -1.0 : milliseconds[milliseconds.size() * 99 / 100];
    }
};

Health ask_how_it_is(const test::ServiceProcess& service, const std::stop_token& stop) {
    Health health;
    while (!stop.stop_requested()) {
        const auto begin = Clock::now();
        if (service.get("/healthz").first == 200) {
            health.milliseconds.push_back(
                std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
        } else {
            ++health.failures;
        }
        std::this_thread::sleep_for(10ms);
    }
    std::sort(health.milliseconds.begin(), health.milliseconds.end());
    return health;
}

void allow_many_files() {
    rlimit files{};
    ::getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &files);
}

Json request_of_bake() {
    Json request = test::costly_request(30, 8);
    request["quality"]["settings"]["leaf_grid"] = 4;
    return request;
}

void fight(bool behind_proxy) {
    std::signal(SIGPIPE, SIG_IGN);  // an attacked service closes connections that are written to
    const int seconds = test::form("PROBEBAKE_ATTACK_SECONDS", 3);
    allow_many_files();
    const test::TempFolder folder;
    test::ServiceProcess service(folder.path(), behind_proxy, {"--max-running", "2"});
    ASSERT_TRUE(service.running()) << service.process().err();
    // Undisturbed first.
    const std::string calm = service.submit(request_of_bake()).value_or("");
    ASSERT_EQ(service.wait_until_ended(calm), "SUCCEEDED");
    const auto expected = service.digests(calm);
    ASSERT_EQ(expected.size(), 30U);
    Battle battle{.port = service.port(), .behind_proxy = behind_proxy, .file = {}, .victim = {}};
    battle.file.target = "/v1/bakes/" + calm + "/probes/p0/albedo/cube.exr";
    battle.file.bytes = service.get(battle.file.target).second;
    Json endless = test::costly_request(1, 32);
    endless["probes"] = test::grid_request(20, 10, 10)["probes"];
    battle.victim = service.submit(endless).value_or("");
    ASSERT_FALSE(battle.victim.empty());
    // Both jobs that run at a time have their buffers before the attacks.
    ASSERT_EQ(service.wait_until_ended(service.submit(request_of_bake()).value_or("")),
              "SUCCEEDED");
    const uint64_t before = service.resident_bytes();

    uint64_t most = 0;
    int bakes = 0;
    Health health;
    {
        const std::vector<Attack> attacks = {
            hold_idle_connections, drip,    do_not_read,    send_large_bodies,
            send_large_heads,      smuggle, ask_for_ranges, send_bad_requests};
        std::vector<std::jthread> attackers;
        for (uint32_t i = 0; i < attacks.size(); ++i) {
            attackers.emplace_back(
                [&, i](const std::stop_token& stop) { attacks[i](battle, stop, 2 + i); });
        }
        std::jthread watcher(
            [&](const std::stop_token& stop) { health = ask_how_it_is(service, stop); });
        std::jthread baker([&](const std::stop_token& stop) {
            while (!stop.stop_requested()) {
                const std::optional<std::string> id = service.submit(request_of_bake());
                if (!id) continue;
                const std::string state = service.wait_until_ended(*id);
                battle.require(state == "SUCCEEDED", "a bake ended as \"" + state + "\"");
                ++bakes;
            }
        });
        const auto end = Clock::now() + std::chrono::seconds(seconds);
        while (Clock::now() < end) {
            std::this_thread::sleep_for(100ms);
            most = std::max(most, service.resident_bytes());
        }
        watcher.request_stop();
        for (std::jthread& attacker : attackers) attacker.request_stop();
        for (std::jthread& attacker : attackers) attacker.join();
    }
    ASSERT_TRUE(service.running()) << service.process().err();
    for (const std::string& wound : battle.wounds) ADD_FAILURE() << wound;
    // What the attackers left is gone within the time-outs.
    for (int i = 0; i < 2000 && service.get("/healthz").first != 200; ++i) {
        std::this_thread::sleep_for(10ms);
    }
    std::cout << battle.blows << " blows in " << seconds << " s, " << bakes << " bakes meanwhile; "
              << "memory " << static_cast<double>(before) / 1e6 << " MB before, at most "
              << static_cast<double>(most) / 1e6 << " MB; /healthz " << health.milliseconds.size()
              << " times, p99 " << health.p99() << " ms, " << health.failures
              << " without an answer\n";
    // The bytes are those of a calm bake, whatever happened beside it.
    const std::string after = service.submit(request_of_bake()).value_or("");
    EXPECT_EQ(service.wait_until_ended(after), "SUCCEEDED");
    EXPECT_EQ(service.digests(after), expected);
    const auto [status, list] = service.get("/v1/bakes?page_size=100&state=SUCCEEDED");
    ASSERT_EQ(status, 200);
    const Json page = parse_json(list);
    for (const Json& bake : page.at("bakes")) {
        EXPECT_EQ(service.digests(bake.at("id")), expected);
    }
    EXPECT_EQ(parse_json(service.get("/v1/bakes/" + battle.victim).second).at("state"), "RUNNING")
        << "a hidden request came through";
    if (!test::sanitized()) {
        EXPECT_LT(most, before + (uint64_t{64} << 20));
    }
    if (!behind_proxy) return;  // a lock-out by idle connections is allowed there
    EXPECT_EQ(health.failures, 0U) << "a lock-out";
    EXPECT_LT(health.p99(), seconds >= 60 ? 50.0 : 1000.0);
}

TEST(AttackBake, C14_AloneOnLoopback) { fight(false); }

TEST(AttackBake, C14_BehindTheProxy) {
    if (!std::filesystem::exists(test::ServiceProcess::kNginx)) {
        GTEST_SKIP() << "no nginx: scripts/install-packages proxy";
    }
    fight(true);
}

}  // namespace
}  // namespace probebake
