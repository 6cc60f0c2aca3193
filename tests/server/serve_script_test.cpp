// scripts/serve: the service and nginx in front of it, as an installation has them.
#include <gtest/gtest.h>
#include <httplib.h>

#include <fstream>

#include "io/json.h"
#include "io/sha256.h"
#include "net_jobs.h"
#include "process.h"
#include "raw_client.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class ServeScriptTest : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists("/usr/sbin/nginx")) {
            GTEST_SKIP() << "no nginx: scripts/install-packages proxy";
        }
        test::write_scenes(folder_.path() / "scenes");
        script_.emplace(
            folder_.path() / "script",
            std::vector<std::string>{
                "--pdeathsig", "TERM", std::string(PROBEBAKE_SOURCE_DIR) + "/scripts/serve",
                "--listen", "127.0.0.1:" + std::to_string(port_), "--host-name", "bakes.example",
                "--max-upload-mib", "2", "--data", path("data"), "--scenes", path("scenes"),
                "--threads", "2", "--drain-seconds", "0"},
            test::Process::Program{
                "/usr/bin/setpriv",
                {"PROBEBAKE=" PROBEBAKE_BINARY, "PROBEBAKE_RUN=" + path("run")}});
        for (int i = 0; i < 3000 && status("/healthz") != 200; ++i) {
            ASSERT_FALSE(script_->wait(0ms)) << script_->err();
            std::this_thread::sleep_for(10ms);
        }
        ASSERT_EQ(status("/healthz"), 200) << script_->err();
    }

    // In order: what the script started outlives a killed script.
    void TearDown() override {
        if (script_) script_->end();
    }

    std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
    httplib::Client client() const {
        httplib::Client client("127.0.0.1", port_);
        client.set_read_timeout(30);
        return client;
    }
    int status(const std::string& target) const {
        const httplib::Result got = client().Get(target);
        return got ? got->status : 0;
    }
    /// A refusal of nginx's own is one of ours in form.
    static void expect_problem(const httplib::Result& got, int status, const std::string& type) {
        ASSERT_TRUE(got);
        EXPECT_EQ(got->status, status) << got->body;
        EXPECT_EQ(got->get_header_value("Content-Type"), "application/problem+json") << got->body;
        const Json problem = parse_json(got->body);
        EXPECT_EQ(problem.at("type"), "urn:probebake:" + type);
        EXPECT_EQ(problem.at("status"), status);
        EXPECT_TRUE(problem.contains("title") && problem.contains("detail"));
        EXPECT_EQ(problem.at("request_id"), got->get_header_value("X-Request-Id"));
    }

    test::TempFolder folder_;
    const int port_ = test::free_port();
    std::optional<test::Process> script_;
};

TEST_F(ServeScriptTest, BakesBehindTheProxyAndEndsWithIt) {
    const std::string body = test::net_request(2).dump();
    const httplib::Result taken =
        client().Post("/v1/bakes", {{"Prefer", "wait=30"}}, body, "application/json");
    ASSERT_TRUE(taken);
    ASSERT_EQ(taken->status, 201) << taken->body;
    const std::string bake = taken->get_header_value("Location");
    const std::string file = bake + "/probes/p1/albedo/cube.exr";
    const httplib::Result whole = client().Get(file);
    ASSERT_EQ(whole->status, 200);
    EXPECT_EQ(whole->get_header_value("ETag"),
              "\"" + sha256_hex(std::as_bytes(std::span(whole->body))) + "\"");
    EXPECT_FALSE(whole->get_header_value("Repr-Digest").empty());
    const httplib::Result part = client().Get(file, {{"Range", "bytes=10-19"}});
    EXPECT_EQ(part->status, 206);
    EXPECT_EQ(part->body, whole->body.substr(10, 10));
    EXPECT_NE(client().Get(bake + "/events")->body.find("event: end"), std::string::npos);

    EXPECT_EQ(client().Get("/healthz", {{"Host", "bakes.example"}})->status, 200);
    expect_problem(client().Get("/healthz", {{"Host", "evil.example"}}), 421, "unknown-host");
    expect_problem(client().Get("/metrics"), 404, "not-found");
    expect_problem(client().Get("/" + std::string(40'000, 'a')), 400, "malformed-http");
    const std::string large((size_t{3} << 19), 'x');  // 1.5 MiB
    expect_problem(client().Post("/v1/bakes", large, "application/json"), 413, "body-too-large");
    // Of a scene, that much is allowed: the service itself says what it lacks.
    const httplib::Result scene = client().Put("/v1/scenes/castle", large, "application/x-tar");
    EXPECT_EQ(parse_json(scene->body).at("type"), "urn:probebake:digest-required");

    script_->signal(SIGTERM);
    EXPECT_EQ(script_->wait(), 0) << script_->err();
    EXPECT_NE(script_->err().find("\"peer\":\"127.0.0.1\""), std::string::npos)
        << "whose request it was";
    EXPECT_EQ(status("/healthz"), 0);
    EXPECT_FALSE(fs::exists(path("run/probebake.sock")));
}

TEST_F(ServeScriptTest, NoneOfThePairOutlivesTheOther) {
    pid_t nginx = 0;
    std::ifstream(path("run/nginx.pid")) >> nginx;
    ASSERT_GT(nginx, 0);
    ::kill(nginx, SIGKILL);
    ASSERT_TRUE(script_->wait(20s)) << script_->err();
    EXPECT_FALSE(fs::exists(path("run/probebake.sock"))) << "the service was not ended in order";
    EXPECT_FALSE(test::RawClient(port_).connected()) << "a worker of nginx still listens";
}

TEST_F(ServeScriptTest, WhatNginxRefusesIsInTheServicesForm) {
    for (const char* host : {"localhost", "evil.example"}) {
        const std::string answer =
            test::exchange(port_, std::string("TRACE / HTTP/1.1\r\nConnection: close\r\nHost: ") +
                                      host + "\r\n\r\n");
        EXPECT_EQ(test::status_of(answer), 501) << answer;
        EXPECT_NE(answer.find("urn:probebake:unknown-method"), std::string::npos) << answer;
        EXPECT_NE(answer.find("application/problem+json"), std::string::npos) << answer;
    }
}

// What the script says before it starts anything.
TEST(ServeScriptOptions, BeyondLoopbackItWantsTokensOrAFlag) {
    const test::TempFolder folder;
    const auto said = [&](std::vector<std::string> args) {
        args.insert(args.end(), {"--no-such-option"});  // the service ends at once
        test::Process script(
            folder.path() / "script", args,
            {PROBEBAKE_SOURCE_DIR "/scripts/serve", {"PROBEBAKE=" PROBEBAKE_BINARY}});
        EXPECT_NE(script.wait().value_or(0), 0);
        return script.err();
    };
    const std::string refused = "wants --tokens";
    const std::string warned = "warning: no --tokens";
    test::write_text(folder.path() / "with.toml", "tokens = \"tokens.json\"\n");
    test::write_text(folder.path() / "without.toml", "# tokens = \"tokens.json\"\n");
    const std::string with = (folder.path() / "with.toml").string();
    const std::string without = (folder.path() / "without.toml").string();
    for (const char* address : {"0.0.0.0:0", "[::]:0", "8080", "127.0.0.1.example.org:0"}) {
        EXPECT_NE(said({"--listen", address}).find(refused), std::string::npos) << address;
    }
    const std::string anywhere = "0.0.0.0:0";
    EXPECT_NE(said({"--listen", anywhere, "--config", without}).find(refused), std::string::npos);
    const std::string open = said({"--listen", anywhere, "--expose-without-tokens"});
    EXPECT_NE(open.find(warned), std::string::npos) << open;
    EXPECT_EQ(open.find(refused), std::string::npos) << open;
    for (const std::vector<std::string>& args :
         std::vector<std::vector<std::string>>{{"--listen", anywhere, "--tokens", "tokens.json"},
                                               {"--listen", anywhere, "--config", with},
                                               {"--listen", "127.0.0.1:0"},
                                               {"--listen", "[::1]:0"},
                                               {}}) {
        EXPECT_EQ(said(args).find("--tokens:"), std::string::npos) << said(args);
    }
}

}  // namespace
}  // namespace probebake
