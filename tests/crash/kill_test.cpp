// C1, C8, C10 and C11: the service is killed, its clock jumps, a job kills it, it is asked to end.
#include <httplib.h>
#include <sqlite3.h>

#include <random>
#include <set>

#include "crash_fixture.h"
#include "io/json.h"
#include "io/sha256.h"
#include "server/net_jobs.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using test::Process;
using test::TempFolder;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

class KillTest : public testing::Test {
  protected:
    KillTest() { test::write_scenes(folder_.path() / "scenes"); }

    std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
    /// Seconds until it answers.
    double start(std::vector<std::string> more = {}, std::vector<std::string> environment = {}) {
        fs::remove(path("port"));
        std::vector<std::string> args = {
            "serve",        "--port",      "0",          "--data",    path("data"), "--scenes",
            path("scenes"), "--port-file", path("port"), "--threads", "2"};
        args.insert(args.end(), more.begin(), more.end());
        const auto begin = Clock::now();
        service_.emplace(folder_.path() / "service", args,
                         Process::Program{PROBEBAKE_BINARY, std::move(environment)});
        while (!fs::exists(path("port")) && Clock::now() - begin < 60s) {
            if (service_->wait(1ms)) return -1.0;
        }
        const std::string port = test::read_text(path("port"));
        client_ = std::make_unique<httplib::Client>("127.0.0.1", std::stoi(port));
        client_->set_read_timeout(30);
        EXPECT_EQ(client_->Get("/healthz")->status, 200);
        return std::chrono::duration<double>(Clock::now() - begin).count();
    }
    void kill() {
        service_->signal(SIGKILL);
        EXPECT_EQ(service_->wait(), -1);
    }
    std::optional<Json> get(const std::string& target) const {
        const httplib::Result got = client_->Get(target);
        if (!got || got->status != 200) return std::nullopt;
        return parse_json(got->body);
    }
    /// The id of an accepted job; none where no answer came.
    std::optional<std::string> submit(const Json& request, const std::string& key = {}) const {
        httplib::Headers headers;
        if (!key.empty()) headers.emplace("Idempotency-Key", key);
        const httplib::Result got =
            client_->Post("/v1/bakes", headers, request.dump(), "application/json");
        if (!got || got->status != 202) return std::nullopt;
        return parse_json(got->body).at("id").get<std::string>();
    }
    Json wait_until_ended(const std::string& id) {
        for (int i = 0; i < 60000; ++i) {
            const std::optional<Json> bake = get("/v1/bakes/" + id);
            if (bake && bake->contains("ended_at")) return *bake;
            if (!bake && service_->wait(0ms)) return {};
            std::this_thread::sleep_for(10ms);
        }
        ADD_FAILURE() << "waited too long for " << id;
        return {};
    }
    /// Digest of every file, by name, each fetched and compared with what the rows say of it.
    std::map<std::string, std::string> files_of(const std::string& id) const {
        std::map<std::string, std::string> files;
        std::string token;
        do {
            const std::optional<Json> page =
                get("/v1/bakes/" + id + "/probes?page_size=100" + token);
            if (!page) {
                ADD_FAILURE() << "no rows of " << id;
                return files;
            }
            for (const Json& row : page->at("rows")) {
                for (const Json& file : row.at("files")) {
                    const char* const of = row.contains("grid") ? "grid" : "probe";
                    const std::string name = row.at(of).get<std::string>() + "/" +
                                             row.at("state").get<std::string>() + "/" +
                                             file.at("name").get<std::string>();
                    const auto got = client_->Get(
                        std::string("/v1/bakes/").append(id).append("/probes/").append(name));
                    EXPECT_TRUE(got && got->status == 200) << name;
                    if (!got) continue;
                    const std::string digest = sha256_hex(std::as_bytes(std::span(got->body)));
                    EXPECT_EQ(digest, file.at("sha256")) << name;
                    EXPECT_TRUE(files.emplace(name, digest).second) << "twice: " << name;
                }
            }
            token = page->contains("next_page_token")
                        ? "&page_token=" + page->at("next_page_token").get<std::string>()
                        : "";
        } while (!token.empty());
        return files;
    }

    TempFolder folder_;
    std::optional<Process> service_;
    std::unique_ptr<httplib::Client> client_;
};

/// Cheap probes without a pilot; the seed is in the bytes.
Json request_of_kind(int kind) {
    Json request = test::costly_request(2 + kind, 8);
    request["quality"]["settings"]["leaf_grid"] = 4;
    request["seed"] = 100 + kind;
    request["lighting_states"] = {"albedo", "emission"};
    return request;
}

TEST_F(KillTest, C1_NothingIsLostWhereverItIsKilled) {
    const int kills = test::form("PROBEBAKE_KILLS", 50);
    // Kills are no crashes of a job's making: nothing is to be taken for poison.
    const std::vector<std::string> options = {
        "--poison-after",   "1000000", "--max-queued", "10000",
        "--max-per-tenant", "10000",   "--keep-jobs",  "100000"};
    constexpr int kKinds = 4;
    start(options);
    std::vector<std::map<std::string, std::string>> expected;
    std::set<std::string> first;
    for (int kind = 0; kind < kKinds; ++kind) {
        const std::string id = *submit(request_of_kind(kind));
        wait_until_ended(id);
        expected.push_back(files_of(id));
        first.insert(id);
    }
    std::mt19937_64 random(11);
    std::map<std::string, std::string> accepted;  // id by key
    std::set<std::string> unanswered;             // keys
    int made = 0;
    double slowest = 0.0;
    for (int i = 0; i < kills; ++i) {
        const auto kill_at = Clock::now() + std::chrono::microseconds(random() % 300'000);
        std::jthread killer([&] {
            std::this_thread::sleep_until(kill_at);
            service_->signal(SIGKILL);
        });
        // What got no answer is sent again; then two new ones.
        std::vector<std::string> keys(unanswered.begin(), unanswered.end());
        for (int k = 0; k < 2; ++k) keys.push_back("key-" + std::to_string(made++));
        for (const std::string& key : keys) {
            const int kind = std::stoi(key.substr(4)) % kKinds;
            if (const auto id = submit(request_of_kind(kind), key)) {
                const auto [at, is_new] = accepted.emplace(key, *id);
                EXPECT_EQ(at->second, *id) << "one key, two jobs";
                unanswered.erase(key);
            } else {
                unanswered.insert(key);
            }
        }
        killer.join();
        EXPECT_EQ(service_->wait(), -1);
        const double ready = start(options);
        ASSERT_GT(ready, 0.0) << service_->err();
        slowest = std::max(slowest, ready);
    }
    for (const std::string& key : unanswered) {
        const auto id = submit(request_of_kind(std::stoi(key.substr(4)) % kKinds), key);
        ASSERT_TRUE(id);
        accepted[key] = *id;
    }
    int lost = 0;
    int wrong = 0;
    for (const auto& [key, id] : accepted) {
        const Json bake = wait_until_ended(id);
        lost += bake.is_null() || bake.at("state") != "SUCCEEDED" ? 1 : 0;
        wrong += files_of(id) != expected[static_cast<size_t>(std::stoi(key.substr(4)) % kKinds)]
                     ? 1
                     : 0;
    }
    // No job that nobody asked for.
    std::set<std::string> all;
    std::string token;
    do {
        const Json page = *get("/v1/bakes?page_size=100" + token);
        for (const Json& bake : page.at("bakes")) all.insert(bake.at("id"));
        token = page.contains("next_page_token")
                    ? "&page_token=" + page["next_page_token"].get<std::string>()
                    : "";
    } while (!token.empty());
    std::cout << kills << " kills, " << accepted.size() << " jobs: " << lost << " lost, "
              << static_cast<int>(all.size() - accepted.size() - first.size()) << " duplicates, "
              << wrong << " with wrong bytes; slowest start " << slowest << " s\n";
    EXPECT_EQ(lost, 0);
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(all.size(), accepted.size() + first.size());
}

TEST_F(KillTest, C1_AtlasesOfAKilledJobAreThoseOfAnUndisturbedOne) {
    Json request = test::costly_request(1, 8);
    request["quality"]["settings"]["leaf_grid"] = 4;
    request["probes"] = test::grid_request(4, 2, 2)["probes"];
    request["products"] = {"sh", "ddgi"};
    start();
    const std::string whole = *submit(request);
    wait_until_ended(whole);
    const auto expected = files_of(whole);
    ASSERT_EQ(expected.size(), 16U + 2);
    const std::string id = *submit(request);
    for (const uint64_t done : {uint64_t{1}, uint64_t{7}, uint64_t{12}, uint64_t{16}}) {
        for (Json bake = *get("/v1/bakes/" + id);
             !bake.contains("ended_at") && bake.at("progress").at("units_done") < done;) {
            bake = *get("/v1/bakes/" + id);
        }
        kill();
        ASSERT_GT(start(), 0.0);
    }
    EXPECT_EQ(wait_until_ended(id).at("state"), "SUCCEEDED");
    EXPECT_EQ(files_of(id), expected);
    if (test::sanitized()) return;  // the shim and a sanitizer do not go together
    // And while it writes the second atlas.
    kill();
    fs::remove_all(path("data"));
    start({},
          {"SHIM_ROOT=" + path("data"), "SHIM_KILL=" + expected.at("g/albedo/ddgi-distance.exr"),
           "LD_PRELOAD=" PROBEBAKE_SHIM});
    const std::string again = *submit(request);
    EXPECT_EQ(service_->wait(), -1);
    ASSERT_GT(start(), 0.0);
    EXPECT_EQ(wait_until_ended(again).at("state"), "SUCCEEDED");
    EXPECT_EQ(files_of(again), expected);
}

TEST_F(KillTest, C1_TenThousandJobsDoNotDelayTheStart) {
    start();
    kill();
    sqlite3* db = nullptr;
    ASSERT_EQ(::sqlite3_open((path("data") + "/probebake.sqlite").c_str(), &db), SQLITE_OK);
    const char* sql =
        "BEGIN;"
        "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 10000)"
        " INSERT INTO jobs (id, tenant, state, scene, scene_sha256, request, request_sha256,"
        " created, started, ended, units, units_done, warnings)"
        " SELECT printf('b-%032x', i), 'local', 3, 'net', 's', hex(zeroblob(1000)), 'r', i, i,"
        " unixepoch() * 1000, 10, 10, '[]' FROM n;"
        "INSERT INTO units (job, unit, probe, lighting, state, attempt, position)"
        " SELECT sequence, u.value, printf('p%d', u.value), 'albedo', 2, 1, u.value"
        " FROM jobs, json_each('[0,1,2,3,4,5,6,7,8,9]') u;"
        "INSERT INTO files (job, unit, name, bytes, sha256) SELECT job, unit, 'cube.exr', 1,"
        " printf('%064x', job * 100 + unit) FROM units;"
        "COMMIT;";
    char* problem = nullptr;
    ASSERT_EQ(::sqlite3_exec(db, sql, nullptr, nullptr, &problem), SQLITE_OK) << problem;
    ::sqlite3_close(db);
    double best = 1e9;
    for (int i = 0; i < 3; ++i) {
        best = std::min(best, start({"--keep-jobs", "100000"}));
        kill();
    }
    std::cout << "ready after " << best << " s with 10,000 jobs of 10 units\n";
    EXPECT_LT(best, test::sanitized() ? 20.0 : 2.0);
    start({"--keep-jobs", "100000"});
    EXPECT_EQ(get("/v1/bakes?page_size=100")->at("bakes").size(), 100U);
}

TEST_F(KillTest, C8_AClockThatJumpsChangesNothing) {
    if (test::sanitized()) GTEST_SKIP() << "the shim and a sanitizer do not go together";
    const std::vector<std::string> clock = {"SHIM_CLOCK=" + path("clock"),
                                            "LD_PRELOAD=" PROBEBAKE_SHIM};
    start({"--keep-days", "1"}, clock);
    const std::string before = *submit(request_of_kind(0));
    wait_until_ended(before);
    const auto expected = files_of(before);
    for (const char* jump : {"86400000", "-3000000000", "0"}) {
        const auto begin = Clock::now();
        const std::string id = *submit(request_of_kind(0));
        test::write_text(path("clock"), jump);
        EXPECT_EQ(wait_until_ended(id).at("state"), "SUCCEEDED");
        EXPECT_LT(Clock::now() - begin, 60s);
        EXPECT_EQ(files_of(id), expected);
        std::this_thread::sleep_for(2500ms);  // time for the retention to be wrong
        EXPECT_TRUE(get("/v1/bakes/" + before)) << "removed by a clock that jumped by " << jump;
    }
}

TEST_F(KillTest, C10_AProbeThatKillsTheServiceIsGivenUpAfterThreeTimes) {
    if (test::sanitized()) GTEST_SKIP() << "the shim and a sanitizer do not go together";
    start();
    const std::string good = *submit(request_of_kind(3));
    wait_until_ended(good);
    const auto expected = files_of(good);
    kill();
    fs::remove_all(path("data"));
    // Its bytes are always the same, so that the shim knows it when it comes.
    const std::string digest = expected.at("p1/albedo/cube.exr");
    const std::vector<std::string> trap = {"SHIM_ROOT=" + path("data"), "SHIM_KILL=" + digest,
                                           "LD_PRELOAD=" PROBEBAKE_SHIM};
    start({}, trap);
    const std::string other = *submit(request_of_kind(0));
    const std::string id = *submit(request_of_kind(3));
    int deaths = 0;
    while (service_->wait(120s) == -1 && deaths < 10) {
        ++deaths;
        if (start({}, trap) < 0) continue;
        if (deaths == 3) break;
    }
    EXPECT_EQ(deaths, 3);
    const Json bake = wait_until_ended(id);
    EXPECT_EQ(bake.at("state"), "FAILED");
    ASSERT_EQ(bake.at("error").at("errors").size(), 1U) << bake.dump();
    EXPECT_EQ(bake.at("error").at("errors")[0].at("pointer"), "/probes/p1/albedo");
    EXPECT_EQ(bake.at("progress").at("units_done"), 9);
    EXPECT_EQ(wait_until_ended(other).at("state"), "SUCCEEDED") << "another job was blamed";
    auto rest = expected;
    rest.erase("p1/albedo/cube.exr");
    EXPECT_EQ(files_of(id), rest);
}

TEST_F(KillTest, C11_SigtermDrainsInTime) {
    start({"--drain-seconds", "5"});
    const std::string id = *submit(test::costly_request(5000, 16));
    while (get("/v1/bakes/" + id)->at("progress").at("units_done") < 1) {
    }
    const auto begin = Clock::now();
    service_->signal(SIGTERM);
    EXPECT_EQ(service_->wait(), 0);
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    std::cout << "ended " << seconds << " s after SIGTERM with 5 s of grace\n";
    EXPECT_LT(seconds, 30.0);
    EXPECT_GE(seconds, 4.9);
    start();
    const Json bake = *get("/v1/bakes/" + id);
    EXPECT_NE(bake.at("state"), "FAILED");
    EXPECT_GT(bake.at("progress").at("units_done"), 0);
}

}  // namespace
}  // namespace probebake
