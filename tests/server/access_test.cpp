// Tokens, scopes, tenants.
#include "http/access.h"

#include <gtest/gtest.h>

#include "running_service.h"

namespace probebake {
namespace {

using test::Answer;
using test::RunningService;

constexpr const char* kNow = "2026-06-01T12:00:00.000Z";

class AccessTest : public testing::Test {
  protected:
    std::string add(const std::string& tenant, const std::vector<std::string>& scopes,
                    const std::string& expires_at = {}) {
        std::string token = new_token();
        entries_.push_back(write_token_entry(token, tenant, scopes, expires_at));
        return token;
    }
    std::filesystem::path file() {
        test::write_text(folder_.path() / "tokens.json", Json{{"tokens", entries_}}.dump());
        return folder_.path() / "tokens.json";
    }

    test::TempFolder folder_;
    Json entries_ = Json::array();
};

httplib::Headers bearer(const std::string& token) { return {{"Authorization", "Bearer " + token}}; }

TEST_F(AccessTest, ATokenIsKnownByItsDigest) {
    const std::string token = add("lab", {"submit", "read"});
    const std::string old = add("lab", {"read"}, "2026-01-01T00:00:00Z");
    const std::string fresh = add("lab", {"metrics"}, "2027-01-01T00:00:00Z");
    const Tokens tokens(file());
    EXPECT_EQ(test::read_text(file()).find(token), std::string::npos);
    const auto who = tokens.find("Bearer " + token, kNow);
    ASSERT_TRUE(who);
    EXPECT_EQ(who->tenant, "lab");
    EXPECT_TRUE(who->may(Scope::kSubmit) && who->may(Scope::kRead) && who->may(Scope::kOpen));
    EXPECT_FALSE(who->may(Scope::kAdmin) || who->may(Scope::kMetrics) || who->sees("other"));
    EXPECT_FALSE(tokens.find("Bearer " + old, kNow)) << "expired";
    EXPECT_TRUE(tokens.find("bearer " + token, kNow)) << "schemes have no case";
    EXPECT_TRUE(tokens.find("BEARER " + token, kNow));
    EXPECT_TRUE(tokens.find("Bearer " + fresh, kNow)->may(Scope::kMetrics));
    for (const std::string& wrong :
         {std::string(), token, std::string("Bearer"), std::string("Bearer "), "Bearer" + token,
          "Bearer " + token + "x", "Bearer " + token.substr(1), "Basic " + token}) {
        EXPECT_FALSE(tokens.find(wrong, kNow)) << wrong;
    }
}

TEST_F(AccessTest, AnExpiryIsATimeOfTheCalendar) {
    for (const char* good : {"2027-01-31T00:00:00Z", "2028-02-29T23:59:59Z"}) {
        EXPECT_NO_THROW(add("lab", {"read"}, good)) << good;
    }
    for (const char* bad :
         {"2027-99-99T99:99:99Z", "2027-02-29T00:00:00Z", "2027-00-01T00:00:00Z",
          "2027-04-31T00:00:00Z", "2027-01-01T24:00:00Z", "2027-01-01T00:60:00Z",
          "2027-01-01T00:00:60Z", "2027-01-01 00:00:00Z", "2027-01-01T00:00:00"}) {
        EXPECT_THROW(add("lab", {"read"}, bad), SpecError) << bad;
    }
}

TEST_F(AccessTest, AFileOfTokensIsReadStrictly) {
    const std::string digest(64, 'a');
    for (const char* bad :
         {R"({"tokens": [{"tenant": "a"}]})", R"([])", R"({"token": []})",
          R"({"tokens": [{"tenant": "a", "sha256": "00", "scopes": ["read"]}]})",
          R"({"tokens": [{"tenant": "A b", "sha256": "D", "scopes": ["read"]}]})",
          R"({"tokens": [{"tenant": "a", "sha256": "D", "scopes": ["root"]}]})",
          R"({"tokens": [{"tenant": "a", "sha256": "D", "expires_at": "tomorrow"}]})",
          R"({"tokens": [{"tenant": "a", "sha256": "D", "scopes": [], "secret": 1}]})"}) {
        std::string text = bad;
        if (const size_t at = text.find("\"D\""); at != std::string::npos) {
            text.replace(at + 1, 1, digest);
        }
        test::write_text(folder_.path() / "bad.json", text);
        EXPECT_THROW(Tokens{folder_.path() / "bad.json"}, SpecError) << bad;
    }
    EXPECT_THROW(Tokens{folder_.path() / "none.json"}, IoError);
}

TEST_F(AccessTest, TenantsSeeTheirOwnJobsOnly) {
    const std::string a = add("a", {"submit", "read"});
    const std::string b = add("b", {"submit", "read"});
    const std::string reader = add("a", {"read"});
    const std::string admin = add("ops", {"admin"});
    const RunningService service([&](ServiceOptions& options) { options.tokens = file(); });

    const Json request = test::net_request(1);
    const Answer nobody = service.post("/v1/bakes", request);
    EXPECT_EQ(nobody.status, 401);
    EXPECT_EQ(nobody.header("WWW-Authenticate"), "Bearer");
    EXPECT_EQ(service.post("/v1/bakes", bearer(reader), request).status, 403);
    const Answer taken = service.post("/v1/bakes", bearer(a), request);
    ASSERT_EQ(taken.status, 202) << taken.body;
    const std::string bake = "/v1/bakes/" + taken.json().at("id").get<std::string>();
    for (int i = 0; i < 6000; ++i) {
        if (service.get(bake, bearer(a)).json().contains("ended_at")) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }

    for (const char* rest :
         {"", "/report", "/probes", "/events", "/archive.tar", "/probes/p0/albedo/cube.exr"}) {
        EXPECT_EQ(service.get(bake + rest, bearer(reader)).status, 200) << rest;
        EXPECT_EQ(service.get(bake + rest, bearer(admin)).status, 200) << rest;
        const Answer other = service.get(bake + rest, bearer(b));
        EXPECT_EQ(other.status, 404) << rest;
        EXPECT_EQ(other.json().at("type"), "urn:probebake:unknown-bake");
        EXPECT_EQ(service.get(bake + rest).status, 401) << rest;
    }
    EXPECT_EQ(service.remove(bake, bearer(b)).status, 404);
    EXPECT_EQ(service.remove(bake, bearer(reader)).status, 403);
    EXPECT_EQ(service.get("/v1/bakes", bearer(b)).json().at("bakes").size(), 0U);
    EXPECT_EQ(service.get("/v1/bakes", bearer(admin)).json().at("bakes").size(), 1U);
    EXPECT_EQ(service.get("/metrics", bearer(a)).status, 403);
    EXPECT_EQ(service.get("/metrics", bearer(admin)).status, 200);
    for (const char* open : {"/healthz", "/readyz", "/v1/version", "/v1/limits", "/openapi.json"}) {
        EXPECT_EQ(service.get(open).status, 200) << open;
    }
    EXPECT_EQ(service.remove(bake, bearer(a)).status, 204);
    EXPECT_EQ(service.get(bake, bearer(a)).status, 404);
}

TEST_F(AccessTest, AnExpiredBakeIsGoneForItsTenantAndUnknownToOthers) {
    const std::string a = add("a", {"submit", "read"});
    const std::string b = add("b", {"submit", "read"});
    const RunningService service([&](ServiceOptions& options) {
        options.tokens = file();
        options.jobs.keep_jobs = 1;
    });
    std::string first;
    for (int i = 0; i < 2; ++i) {
        const httplib::Headers headers = {{"Authorization", "Bearer " + a}, {"Prefer", "wait=30"}};
        const Answer done = service.post("/v1/bakes", headers, test::net_request(1));
        ASSERT_EQ(done.status, 201) << done.body;
        if (first.empty()) first = done.header("Location");
    }
    for (int i = 0; i < 1000 && service.get(first, bearer(a)).status != 410; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_EQ(service.get(first, bearer(a)).status, 410);
    EXPECT_EQ(service.get(first, bearer(b)).status, 404);
    EXPECT_EQ(service.get(first).status, 401);
}

}  // namespace
}  // namespace probebake
