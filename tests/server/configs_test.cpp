// The examples in configs/ work: every scene file is one, every job can be baked.
#include <gtest/gtest.h>

#include <regex>

#include "io/file.h"
#include "running_service.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using test::RunningService;

const fs::path kConfigs = PROBEBAKE_SOURCE_DIR "/configs";

TEST(Configs, EverySceneFileIsOneAndEveryGeneratorHasOne) {
    const SceneLibrary library(kConfigs / "scenes");
    std::set<std::string> shown;
    for (const std::string& name : library.names()) {
        const std::optional<SceneFile> file = library.find(name);
        ASSERT_TRUE(file) << name;
        EXPECT_FALSE(file->description.empty()) << name;
        ASSERT_TRUE(file->generator) << name << " needs a file that is not part of the sources";
        shown.insert(file->generator->name);
    }
    for (const GeneratorInfo& info : generators()) {
        EXPECT_TRUE(shown.contains(std::string(info.name))) << info.name;
    }
}

TEST(Configs, EveryJobIsBaked) {
    const RunningService service([](ServiceOptions& options) {
        options.scenes = fs::path(PROBEBAKE_SOURCE_DIR) / "configs/scenes";
    });
    size_t jobs = 0;
    for (const auto& entry : fs::directory_iterator(kConfigs / "jobs")) {
        const std::string text = test::read_text(entry.path());
        const std::string id = service.bake(parse_json(text));
        const Json report = service.get("/v1/bakes/" + id + "/report").json();
        EXPECT_GT(report.at("totals").at("cubemaps"), 0) << entry.path();
        EXPECT_EQ(report.at("plan").at("warnings"), Json::array()) << entry.path();
        for (const Json& state : report.at("states")) {
            for (const auto& [result, count] : state.at("results").items()) {
                EXPECT_EQ(result, "target_met") << entry.path();
            }
        }
        ++jobs;
    }
    EXPECT_GE(jobs, 5U);
}

TEST(Configs, AlertsAndDashboardNameMetricsThatThereAre) {
    const RunningService service;
    service.bake(test::net_request(1));
    const std::string metrics = service.get("/metrics").body;
    const std::regex name("probebake_[a-z0-9_]+");
    for (const char* file : {"prometheus-alerts.yaml", "grafana-dashboard.json"}) {
        const std::string text = test::read_text(kConfigs / file);
        std::set<std::string> named;
        for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end; ++at) {
            named.insert(at->str());
        }
        EXPECT_GE(named.size(), 9U) << file;
        for (const std::string& metric : named) {
            EXPECT_NE(metrics.find(metric), std::string::npos) << metric << " of " << file;
        }
    }
    EXPECT_EQ(parse_json(test::read_text(kConfigs / "grafana-dashboard.json")).at("title"),
              "probebake");
}

}  // namespace
}  // namespace probebake
