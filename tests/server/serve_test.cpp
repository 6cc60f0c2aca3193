// The real binary: serve and its clients, as a user runs them.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <map>
#include <sstream>

#include "io/json.h"
#include "net_jobs.h"
#include "process.h"
#include "raw_client.h"
#include "support/sanitized.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using test::Process;
using test::TempFolder;
using test::write_text;
using namespace std::chrono_literals;

struct Ran {
    int code = 0;
    std::string out;
    std::string err;
};

/// What comes back for these bytes over a unix socket; nothing where nobody listens.
std::string unix_exchange(const std::string& path, const std::string& bytes) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    const int client = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    std::string text;
    if (::connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 &&
        ::send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL) > 0) {
        std::array<char, 4096> buffer{};
        for (ssize_t n = 0; (n = ::recv(client, buffer.data(), buffer.size(), 0)) > 0;) {
            text.append(buffer.data(), static_cast<size_t>(n));
        }
    }
    ::close(client);
    return text;
}

class ServeTest : public testing::Test {
  protected:
    ServeTest() {
        test::write_scenes(folder_.path() / "scenes");
        write_text(folder_.path() / "job.json", test::net_request(3).dump());
        write_text(folder_.path() / "long.json", test::costly_request(5000, 16).dump());
    }

    std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
    std::vector<std::string> serve_args(std::vector<std::string> more = {}) const {
        std::vector<std::string> args = {
            "serve",        "--port",      "0",          "--data",    path("data"), "--scenes",
            path("scenes"), "--port-file", path("port"), "--threads", "2"};
        args.insert(args.end(), more.begin(), more.end());
        return args;
    }
    void serve(std::vector<std::string> more = {}) {
        fs::remove(path("port"));
        service_.emplace(folder_.path() / "service", serve_args(std::move(more)));
        for (int i = 0; i < 6000 && !fs::exists(path("port")); ++i) {
            std::this_thread::sleep_for(5ms);
        }
        std::string port = test::read_text(path("port"));
        ASSERT_FALSE(port.empty()) << service_->err();
        port.pop_back();
        url_ = "http://127.0.0.1:" + port;
    }
    Ran run(const std::vector<std::string>& args) {
        Process process(folder_.path() / "client", args);
        const std::optional<int> code = process.wait();
        EXPECT_TRUE(code) << args[0] << " does not end";
        return {code.value_or(-1), process.out(), process.err()};
    }
    Ran client(std::vector<std::string> args) {
        args.insert(args.end(), {"--server", url_});
        return run(args);
    }
    std::string submit(const std::string& job) {
        const Ran ran = client({"submit", path(job)});
        EXPECT_EQ(ran.code, 0) << ran.err;
        return ran.out.substr(0, ran.out.find('\n'));
    }

    TempFolder folder_;
    std::optional<Process> service_;
    std::string url_;
};

TEST_F(ServeTest, ClientsGoAllTheWay) {
    serve();
    EXPECT_EQ(service_->out(), "listening on " + url_ + "\n");
    const std::string id = submit("job.json");
    const Ran waited = client({"wait", id});
    EXPECT_EQ(waited.code, 0) << waited.err;
    EXPECT_NE(waited.out.find("SUCCEEDED 3/3"), std::string::npos) << waited.out;

    const Ran listed = client({"list", "--state", "SUCCEEDED", "--json"});
    EXPECT_EQ(parse_json(listed.out).at("bakes").at(0).at("id"), id);
    EXPECT_NE(client({"list"}).out.find(id), std::string::npos);
    EXPECT_EQ(parse_json(client({"status", id, "--json"}).out).at("state"), "SUCCEEDED");

    const Ran got = client({"download", id, "--out", path("out")});
    EXPECT_EQ(got.code, 0) << got.err;
    EXPECT_NE(got.out.find("p2/albedo"), std::string::npos) << "the report's table";
    EXPECT_NE(got.out.find("sizes and SHA-256 checked, 0 of them there before"), std::string::npos);
    EXPECT_EQ(parse_json(test::read_text(path("out/report.json"))).at("totals").at("cubemaps"), 3);

    // What `bake` leaves is the same.
    const Ran baked = run({"bake", path("job.json"), "--out", path("local"), "--scenes",
                           path("scenes"), "--threads", "1"});
    EXPECT_EQ(baked.code, 0) << baked.err;
    for (const char* probe : {"p0", "p1", "p2"}) {
        const std::string file = std::string(probe) + "/albedo/cube.exr";
        EXPECT_EQ(test::read_text(path("out/" + file)), test::read_text(path("local/" + file)));
        EXPECT_FALSE(test::read_text(path("out/" + file)).empty());
    }

    // A second download fetches only what is missing or damaged.
    fs::remove(path("out/p0/albedo/cube.exr"));
    const std::string good = test::read_text(path("out/p1/albedo/cube.exr"));
    std::string bad = good;
    bad[bad.size() / 2] = static_cast<char>(bad[bad.size() / 2] ^ 1);
    write_text(path("out/p1/albedo/cube.exr"), bad);
    const Json again = parse_json(client({"download", id, "--out", path("out"), "--json"}).out);
    EXPECT_EQ(again.at("files"), 3);
    EXPECT_EQ(again.at("kept"), 1);
    EXPECT_EQ(again.at("complete"), true);
    EXPECT_EQ(test::read_text(path("out/p1/albedo/cube.exr")), good);
}

TEST_F(ServeTest, AUnixSocketIsEnough) {
    const std::vector<std::string> args = {"serve",        "--socket",   path("s"),
                                           "--data",       path("data"), "--scenes",
                                           path("scenes"), "--threads",  "2"};
    write_text(path("s.txt"), "no socket");
    Process service(folder_.path() / "service", args);
    for (int i = 0; i < 6000 && !fs::exists(path("s")); ++i) std::this_thread::sleep_for(5ms);
    EXPECT_EQ(fs::status(path("s")).permissions() & fs::perms::others_all, fs::perms::none);
    EXPECT_EQ(
        unix_exchange(path("s"), "GET /healthz HTTP/1.0\r\nHost: localhost\r\n\r\n").substr(0, 15),
        "HTTP/1.1 200 OK");
    // A second one with data of its own does not take the socket away.
    std::vector<std::string> second = args;
    second[4] = path("other");
    const Ran refused = run(second);
    EXPECT_EQ(refused.code, 1);
    EXPECT_NE(refused.err.find("another service does"), std::string::npos) << refused.err;
    second[2] = path("s.txt");
    EXPECT_EQ(run(second).code, 1) << "a file is not replaced";
    EXPECT_EQ(test::read_text(path("s.txt")), "no socket");
    // What a killed one leaves is replaced; one that ends removes it.
    service.signal(SIGKILL);
    service.wait();
    EXPECT_TRUE(fs::exists(path("s")));
    Process next(folder_.path() / "next", args);
    std::string answer;
    for (int i = 0; i < 600 && answer.empty(); ++i) {
        answer = unix_exchange(path("s"), "GET /healthz HTTP/1.0\r\nHost: localhost\r\n\r\n");
        std::this_thread::sleep_for(50ms);
    }
    EXPECT_FALSE(answer.empty());
    next.signal(SIGTERM);
    EXPECT_EQ(next.wait(), 0);
    EXPECT_FALSE(fs::exists(path("s")));
}

TEST_F(ServeTest, ClientsSayWhatWentWrong) {
    serve();
    write_text(path("bad.json"), R"({"scene": "net", "face_size_px": 0, "probes": {}})");
    const Ran bad = client({"submit", path("bad.json")});
    EXPECT_EQ(bad.code, 1);
    EXPECT_NE(bad.err.find("/face_size_px: is 0"), std::string::npos) << bad.err;
    const Ran unknown = client({"status", "b-0"});
    EXPECT_EQ(unknown.code, 1);
    EXPECT_NE(unknown.err.find("Not Found (404): there is no bake"), std::string::npos);
    EXPECT_EQ(client({"submit", path("missing.json")}).code, 1);
    EXPECT_EQ(client({"submit"}).code, 2);

    const std::string id = submit("long.json");
    EXPECT_EQ(client({"cancel", id}).code, 0);
    const Ran waited = client({"wait", id});
    EXPECT_EQ(waited.code, 1) << "only success is 0";
    EXPECT_NE(waited.out.find("CANCELLED"), std::string::npos);
    const Ran got = client({"download", id, "--out", path("part")});
    EXPECT_EQ(got.code, 0) << got.err;
    EXPECT_NE(got.out.find("no report"), std::string::npos);
    EXPECT_FALSE(fs::exists(path("part/report.json")));

    // What failed by its budget has its report all the same.
    Json request = test::net_request(1, 16);
    request["quality"] = {{"targets", {{"psnr_db", 90.0}}}};
    request["budget"] = {{"rays", 6 * 16 * 16}};
    request["on_budget_exhausted"] = "fail";
    write_text(path("poor.json"), request.dump());
    const std::string poor = submit("poor.json");
    EXPECT_EQ(client({"wait", poor}).code, 1);
    EXPECT_EQ(client({"download", poor, "--out", path("poor")}).code, 0);
    EXPECT_TRUE(fs::exists(path("poor/report.json")));

    service_.reset();
    const Ran gone = client({"list"});
    EXPECT_EQ(gone.code, 1);
    EXPECT_NE(gone.err.find("no answer from " + url_), std::string::npos) << gone.err;
}

TEST_F(ServeTest, SigtermEndsItCleanlyWithinTheGrace) {
    for (const int number : {SIGTERM, SIGINT}) {
        serve({"--drain-seconds", "0.3"});
        const std::string id = submit("long.json");
        std::this_thread::sleep_for(100ms);
        const auto start = std::chrono::steady_clock::now();
        service_->signal(number);
        EXPECT_EQ(service_->wait(), 0) << service_->err();
        EXPECT_LT(std::chrono::steady_clock::now() - start, test::patient(2300ms));
        EXPECT_NE(service_->err().find("\"event\":\"stopped\""), std::string::npos);
        // It goes on where it was.
        serve();
        EXPECT_FALSE(parse_json(client({"status", id, "--json"}).out).contains("ended_at"));
        EXPECT_EQ(client({"cancel", id}).code, 0);
        client({"wait", id});
        service_.reset();
    }
}

TEST_F(ServeTest, ASecondSignalEndsTheGrace) {
    serve({"--drain-seconds", "60"});
    const std::string id = submit("long.json");
    for (int i = 0; i < 100; ++i) {
        if (client({"status", id, "--json"}).out.find("RUNNING") != std::string::npos) break;
    }
    service_->signal(SIGTERM);
    EXPECT_EQ(service_->wait(300ms), std::nullopt) << "a running job has its grace";
    service_->signal(SIGTERM);
    EXPECT_EQ(service_->wait(test::patient(3s)), 0);
}

TEST_F(ServeTest, ASlowUploadDoesNotHoldUpTheEnd) {
    for (const int signals : {1, 2}) {
        serve({"--drain-seconds", signals == 1 ? "0.3" : "20", "--max-upload-mib", "64"});
        test::RawClient slow(std::stoi(url_.substr(url_.rfind(':') + 1)));
        ASSERT_TRUE(
            slow.send("PUT /v1/scenes/castle HTTP/1.1\r\nHost: localhost\r\nContent-Type: "
                      "application/x-tar\r\n"
                      "Repr-Digest: sha-256=:AAAA:\r\nContent-Length: 60000000\r\n\r\nsome of it"));
        std::this_thread::sleep_for(200ms);
        const auto start = std::chrono::steady_clock::now();
        service_->signal(SIGTERM);
        if (signals == 2) {
            EXPECT_EQ(service_->wait(1500ms), std::nullopt) << "an upload has its grace";
            service_->signal(SIGTERM);
        }
        EXPECT_EQ(service_->wait(test::patient(10s)), 0);
        EXPECT_LT(std::chrono::steady_clock::now() - start, test::patient(5s));
        EXPECT_NE(service_->err().find("\"event\":\"stopped\""), std::string::npos);
    }
}

TEST_F(ServeTest, ASceneThatLoadsDoesNotHoldUpTheEnd) {
    write_text(path("scenes/huge.json"),
               R"({"type": "generator", "generator": "forest", "size": 2048})");
    Json request = test::net_request(1);
    request["scene"] = "huge";
    write_text(path("huge-job.json"), request.dump());
    serve({"--drain-seconds", "0"});
    submit("huge-job.json");
    std::this_thread::sleep_for(300ms);
    const auto start = std::chrono::steady_clock::now();
    service_->signal(SIGTERM);
    EXPECT_EQ(service_->wait(), 0);
    EXPECT_LT(std::chrono::steady_clock::now() - start, test::patient(4s));
}

TEST_F(ServeTest, OneServicePerDataDirectoryAndPort) {
    serve();
    const Ran second = run(serve_args());
    EXPECT_EQ(second.code, 1);
    EXPECT_EQ(second.err, "probebake: " + path("data") +
                              ": is the data directory of another running service\n");
    const std::string port = url_.substr(url_.rfind(':') + 1);
    const Ran same_port =
        run({"serve", "--port", port, "--data", path("data2"), "--scenes", path("scenes")});
    EXPECT_EQ(same_port.code, 1);
    EXPECT_NE(same_port.err.find("cannot listen on 127.0.0.1:" + port), std::string::npos);
}

/// Takes from everybody, or gives everybody, the right to write in the folder.
void allow_writing(const fs::path& folder, bool allowed) {
    const fs::perms all = fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
    const fs::perm_options how = allowed ? fs::perm_options::add : fs::perm_options::remove;
    fs::permissions(folder, all, how);
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        fs::permissions(entry.path(), all, how);
    }
}

// Permissions do not bind root, who runs the service as nobody here.
TEST_F(ServeTest, AFolderThatCannotBeWrittenIsRefusedInOneLine) {
    serve();
    service_->signal(SIGTERM);
    ASSERT_EQ(service_->wait(), 0) << service_->err();
    fs::copy_file(PROBEBAKE_BINARY, path("probebake"));  // where nobody can reach it
    fs::permissions(folder_.path(), fs::perms(0755));
    const auto expect_refused = [&](const std::string& data, const std::string& reason) {
        std::vector<std::string> args = serve_args();
        args[4] = data;
        Process::Program program{path("probebake")};
        if (::geteuid() == 0) {
            args.insert(args.begin(), {"--reuid=65534", "--clear-groups", program.path});
            program.path = "/usr/bin/setpriv";
        }
        Process process(folder_.path() / "refused", args, program);
        EXPECT_EQ(process.wait(), 1) << data;
        EXPECT_EQ(process.err(), "probebake: " + reason + "\n");
    };
    allow_writing(path("data"), false);
    expect_refused(path("data"),
                   path("data") + ": cannot be used for data: lock: Permission denied");
    expect_refused(path("data/new"),
                   path("data/new") + ": cannot be used for data: Permission denied");
    allow_writing(path("data"), true);
    for (const std::string folder : {"files", "files/a7", "scenes", "temporary"}) {
        allow_writing(path("data/" + folder), false);
        expect_refused(path("data"), path("data") + ": cannot be used for data: " + folder +
                                         ": Permission denied");
        allow_writing(path("data/" + folder), true);
    }
    fs::permissions(path("data/probebake.sqlite"), fs::perms(0444));
    expect_refused(path("data"), "probebake.sqlite: cannot be opened: it may only be read");
}

TEST_F(ServeTest, DoesNotExposeItselfUnasked) {
    const Ran ran = run(serve_args({"--host", "0.0.0.0"}));
    EXPECT_EQ(ran.code, 1);
    EXPECT_NE(ran.err.find("--expose"), std::string::npos);
    EXPECT_EQ(ran.err.find('\n'), ran.err.size() - 1) << "one line";
    EXPECT_EQ(run(serve_args({"--host", "127.example.org"})).code, 1);
    const Ran open = run(serve_args({"--host", "0.0.0.0", "--expose"}));
    EXPECT_EQ(open.code, 1);
    EXPECT_NE(open.err.find("--tokens"), std::string::npos) << open.err;
    write_text(path("tokens.json"), R"({"tokens": []})");
    serve({"--host", "0.0.0.0", "--expose", "--tokens", path("tokens.json")});
    EXPECT_NE(client({"list"}).err.find("401"), std::string::npos);
}

TEST_F(ServeTest, EveryRequestIsOneLineOfJsonWithoutTokens) {
    const Ran made = run({"token", "--tenant", "lab", "--scopes", "submit,read"});
    const std::string token = made.out.substr(0, made.out.find('\n'));
    const std::string entry = made.out.substr(made.out.find('\n') + 1);
    write_text(path("tokens.json"), R"({"tokens": [)" + entry + "]}");
    serve({"--tokens", path("tokens.json")});
    const int port = std::stoi(url_.substr(url_.rfind(':') + 1));
    const std::vector<std::string> heads = {
        "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX-Real-IP: 6.6.6.6\r\n",
        "GET /v1/bakes HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer " + token + "\r\n",
        "GET /v1/bakes?token=" + token + " HTTP/1.1\r\nHost: localhost\r\n",
        "GET /a\"b%0a{}\\x HTTP/1.1\r\nHost: localhost\r\n",
        "GET /\x1b[31m\xff HTTP/1.1\r\nHost: localhost\r\n",
        "G\"E\nT nonsense\r\n"};
    std::vector<std::string> ids;
    for (const std::string& head : heads) {
        const std::string answer = test::exchange(port, head + "\r\n");
        constexpr std::string_view kName = "X-Request-Id: ";
        const size_t at = answer.find(kName);
        ASSERT_NE(at, std::string::npos) << answer;
        ids.push_back(answer.substr(at + kName.size(), answer.find('\r', at) - at - kName.size()));
    }
    service_->signal(SIGTERM);
    ASSERT_EQ(service_->wait(), 0);
    const std::string log = service_->err();
    EXPECT_EQ(log.find(token), std::string::npos);
    EXPECT_EQ(log.find('\x1b'), std::string::npos);
    std::map<std::string, Json> requests;
    std::istringstream lines(log);
    for (std::string text; std::getline(lines, text);) {
        const Json line = parse_json(text);
        EXPECT_TRUE(line.contains("time") && line.contains("level")) << text;
        if (line.at("event") == "request") requests.emplace(line.at("request_id"), line);
    }
    EXPECT_EQ(requests.size(), ids.size()) << log;
    constexpr std::array<int, 6> kStatus = {200, 200, 401, 404, 400, 400};
    for (size_t i = 0; i < ids.size(); ++i) {
        ASSERT_TRUE(requests.contains(ids[i])) << heads[i];
        const Json& line = requests[ids[i]];
        EXPECT_EQ(line.at("status"), kStatus[i]) << line;
        EXPECT_GE(line.at("seconds"), 0.0);
        EXPECT_GT(line.at("bytes"), 0);
        EXPECT_EQ(line.at("peer"), "127.0.0.1");
    }
    EXPECT_EQ(requests[ids[1]].at("path"), "/v1/bakes");
    EXPECT_EQ(requests[ids[3]].at("path"), "/a\"b%0a{}\\x");
}

TEST_F(ServeTest, WarnsOfBrokenScenesAndStarts) {
    serve();
    EXPECT_NE(service_->err().find("broken-scene"), std::string::npos);
    EXPECT_NE(service_->err().find("atlantis"), std::string::npos);
    EXPECT_EQ(client({"list"}).code, 0);
}

TEST_F(ServeTest, ReadsItsOptionsFromAFile) {
    write_text(path("server.toml"),
               "port = 0\nmax-running = 2\nmax-queued = 7\nexpose = true\n"
               "host = \"0.0.0.0\"\nallow-host = [\"a.example\", \"b\"]\n");
    write_text(path("tokens.json"), R"({"tokens": []})");
    serve({"--config", path("server.toml"), "--max-queued", "9", "--tokens", path("tokens.json")});
    EXPECT_EQ(service_->out().rfind("listening on http://0.0.0.0:", 0), 0U) << service_->out();
    EXPECT_NE(client({"list"}).err.find("401"), std::string::npos);
    write_text(path("server.toml"), "prot = 0\n");
    const Ran ran = run(serve_args({"--config", path("server.toml")}));
    EXPECT_EQ(ran.code, 2);
    EXPECT_NE(ran.err.find("\"prot\" is no option of serve"), std::string::npos) << ran.err;
    EXPECT_EQ(run(serve_args({"--config", path("nowhere.toml")})).code, 2);
}

TEST_F(ServeTest, EveryOptionOfTheExampleIsOne) {
    std::string text = test::read_text(PROBEBAKE_SOURCE_DIR "/configs/server.toml");
    // The options that are commented out, too.
    for (size_t at = text.find("\n# "); at != std::string::npos; at = text.find("\n# ", at + 1)) {
        const size_t end = text.find('\n', at + 1);
        const std::string line = text.substr(at + 3, end - at - 3);
        const size_t equals = line.find(" = ");
        if (equals != std::string::npos && line.find(' ') == equals) text.erase(at + 1, 2);
    }
    EXPECT_NE(text.find("\ncache ="), std::string::npos);
    EXPECT_NE(text.find("\nport-file ="), std::string::npos);
    // Here, and not where the example says.
    for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
             {"port = 8080", "port = 0"},
             {"socket = \"probebake.sock\"\n", ""},  // excludes a port
             {"probebake-data", path("data")},
             {"\"configs/scenes\"", "\"" + path("scenes") + "\""},
             {"probebake-cache", path("cache")},
             {"\"tokens.json\"", "\"" + path("tokens.json") + "\""},
             {"probebake.port", path("port")}}) {
        write_text(path("tokens.json"), R"({"tokens": []})");
        const size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        text.replace(at, from.size(), to);
    }
    write_text(path("server.toml"), text);
    service_.emplace(folder_.path() / "service",
                     std::vector<std::string>{"serve", "--config", path("server.toml")});
    for (int i = 0; i < 2000 && !fs::exists(path("port")); ++i) std::this_thread::sleep_for(5ms);
    EXPECT_TRUE(fs::exists(path("port"))) << service_->err();
}

}  // namespace
}  // namespace probebake
