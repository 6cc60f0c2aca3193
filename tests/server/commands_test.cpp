// The subcommands that need no service, as a user runs them.
#include <gtest/gtest.h>

#include <sstream>

#include "io/json.h"
#include "net_jobs.h"
#include "process.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using test::Process;

class CommandsTest : public testing::Test {
  protected:
    CommandsTest() {
        test::write_scenes(folder_.path() / "scenes");
        test::write_text(path("job.json"), test::net_request(2).dump());
    }

    std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
    /// Its standard output; where it fails, standard error.
    std::string run(const std::vector<std::string>& args, int expected_code = 0) {
        Process process(folder_.path() / "command", args);
        const std::optional<int> code = process.wait();
        EXPECT_EQ(code, expected_code) << process.err();
        return expected_code == 0 ? process.out() : process.err();
    }
    std::string run_on_scenes(std::vector<std::string> args) {
        args.insert(args.end(), {"--scenes", path("scenes")});
        return run(args);
    }

    test::TempFolder folder_;
};

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

TEST_F(CommandsTest, TheErrorTableIsPrintedRowByRow) {
    const std::vector<std::string> all = lines_of(run({"study", "error-table", "--csv"}));
    ASSERT_EQ(all.size(), 1U + 256 * 256);
    EXPECT_EQ(all[0], "mask,dx,dy,dz,ray_cast,sh9,exact,octant_table");

    const std::vector<std::string> some =
        lines_of(run({"study", "error-table", "--csv", "--mask", "1", "--mask", "255",
                      "--direction", "0,0,1", "--direction", "-0.577,0.577,0.577"}));
    ASSERT_EQ(some.size(), 5U);
    double exact = 0.0;
    // One octant of eight, seen along an axis: a quarter of the face is covered.
    EXPECT_EQ(std::sscanf(some[1].c_str(), "1,%*f,%*f,%*f,%*f,%*f,%lf", &exact), 1) << some[1];
    EXPECT_NEAR(exact, 0.75, 1e-12);
    EXPECT_EQ(std::sscanf(some[3].c_str(), "255,%*f,%*f,%*f,%*f,%*f,%lf", &exact), 1) << some[3];
    EXPECT_EQ(exact, 0.0);

    EXPECT_NE(run({"study", "error-table", "--csv", "--direction", "1,1,1"}, 2).find("unit length"),
              std::string::npos);
    EXPECT_NE(run({"study", "error-table", "--csv", "--direction", "nan,0,0"}, 2).find("not nan"),
              std::string::npos);
    run({"study", "error-table", "--csv", "--mask", "256"}, 2);
}

TEST_F(CommandsTest, ScenesDescribeThemselvesAndSuggestProbes) {
    const Json info = parse_json(run_on_scenes({"scene", "info", "net", "--json"}));
    EXPECT_GT(info.at("voxels"), 0);
    const Json probes = parse_json(run_on_scenes({"scene", "probes", "net", "--count", "3"}));
    ASSERT_EQ(probes.at("list").size(), 3U);
    // What is suggested can be baked.
    Json request = test::net_request(1);
    request["probes"] = probes;
    test::write_text(path("suggested.json"), request.dump());
    const Json checked = parse_json(run_on_scenes({"check", path("suggested.json"), "--json"}));
    EXPECT_EQ(checked.at("effective_request").at("probes").at("list").size(), 3U);
}

TEST_F(CommandsTest, ABakeLeavesFilesThatPreviewShows) {
    run_on_scenes({"bake", path("job.json"), "--out", path("out"), "--json"});
    const Json report = parse_json(test::read_text(path("out/report.json")));
    EXPECT_EQ(report.at("totals").at("cubemaps"), 2);
    run({"preview", path("out/p0/albedo/cube.exr"), "--out", path("cross.png")});
    EXPECT_EQ(test::read_text(path("cross.png")).substr(1, 3), "PNG");
    EXPECT_NE(run({"preview", path("job.json"), "--out", path("none.png")}, 1).find("job.json"),
              std::string::npos);
    EXPECT_FALSE(fs::exists(path("none.png")));
}

TEST_F(CommandsTest, AGridsAtlasesHaveAFolderOfTheirOwn) {
    Json request = test::net_request(1);
    const Json origin = request["probes"]["list"][0]["position_m"];
    request["probes"] = {
        {"grids",
         {{{"id", "g"}, {"origin_m", origin}, {"spacing_m", {1, 1, 1}}, {"counts", {2, 1, 1}}}}}};
    request["products"] = {"cube", "ddgi"};
    test::write_text(path("grid.json"), request.dump());
    const std::string shown = run_on_scenes({"bake", path("grid.json"), "--out", path("grid_out")});
    EXPECT_NE(shown.find("g-1-0-0/albedo"), std::string::npos) << shown;
    EXPECT_TRUE(fs::exists(path("grid_out/g-1-0-0/albedo/cube.exr")));
    EXPECT_TRUE(fs::exists(path("grid_out/g/albedo/ddgi-irradiance.exr")));
    EXPECT_TRUE(fs::exists(path("grid_out/g/albedo/ddgi-distance.exr")));
}

TEST_F(CommandsTest, AJobThatCannotBeSaysWhere) {
    test::write_text(path("bad.json"), R"({"scene": "net", "probes": {"list": []}, "sed": 1})");
    Process process(folder_.path() / "command",
                    {"check", path("bad.json"), "--scenes", path("scenes")});
    EXPECT_EQ(process.wait(), 1);
    EXPECT_NE(process.err().find("/sed"), std::string::npos) << process.err();
    EXPECT_NE(process.err().find("/probes"), std::string::npos) << process.err();
}

}  // namespace
}  // namespace probebake
