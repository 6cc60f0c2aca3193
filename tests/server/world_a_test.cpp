// The main job: eight probes at a PSNR target in a world of 17.6 million voxels, over HTTP.
#include <gtest/gtest.h>

#include <cstdio>

#include "commands/report_text.h"
#include "image/exr.h"
#include "io/file.h"
#include "running_service.h"
#include "support/data.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using test::RunningService;

constexpr double kTarget_db = 40.0;

TEST(WorldA, EightProbesMeetAPsnrTargetOverHttp) {
    const std::optional<fs::path> vox = test::data_file("vox/worldA_2048.vox");
    if (!vox) GTEST_SKIP() << "no vox/worldA_2048.vox in PROBEBAKE_DATA";
    const fs::path here = PROBEBAKE_SOURCE_DIR "/tests/server/world_a";
    const RunningService service([&](ServiceOptions& options) {
        fs::copy(here / "world-a.json", options.scenes);
        fs::copy_file(*vox, options.scenes / "worldA_2048.vox");
        options.threads = static_cast<int>(std::thread::hardware_concurrency());
    });
    const std::string id = service.submit(parse_json(test::read_text(here / "job.json")));
    const Json ended = service.wait(
        id, [](const Json& bake) { return bake.contains("ended_at"); }, std::chrono::seconds(300));
    ASSERT_EQ(ended.at("state"), "SUCCEEDED") << ended.dump();

    const std::string path = "/v1/bakes/" + id;
    const Json report = service.get(path + "/report").json();
    const Json page = service.get(path + "/probes").json();
    const auto rows = page.at("rows").get<std::vector<Json>>();
    std::printf("%s\n", report_text(report, rows).c_str());

    EXPECT_EQ(report.at("scene").at("voxels"), 17'605'736);
    EXPECT_EQ(report.at("totals").at("cubemaps"), 8);
    EXPECT_LT(report.at("totals").at("peak_memory_bytes"), 700'000'000);
    ASSERT_EQ(rows.size(), 8U);
    uint64_t rays = 0;
    for (const Json& row : rows) {
        EXPECT_EQ(row.at("result"), "target_met") << row.dump();
        const auto probe = row.at("probe").get<std::string>();
        std::string file = path;
        file.append("/probes/").append(probe).append("/albedo/cube.exr");
        const std::string body = service.get(file).body;
        const std::span<const char> text(body);
        const DecodedCubemap cube = decode_cubemap(std::as_bytes(text), probe);
        EXPECT_EQ(cube.cubemap.face_size(), 64);
        EXPECT_EQ(cube.attributes.id, probe);
        rays += row.at("cost").at("render").at("rays").get<uint64_t>();
    }
    const Json& state = report.at("states").at(0);
    EXPECT_EQ(state.at("cost").at("render").at("rays"), rays);
    EXPECT_GE(state.at("curve").size(), 5U);
    const Json& interval = state.at("error").at("psnr_db_interval");
    EXPECT_GE(state.at("error").at("psnr_db"), kTarget_db);
    EXPECT_GE(interval.at(0), kTarget_db - 1.0);  // every probe's own bound meets it
    EXPECT_LT(interval.at(1).get<double>() - interval.at(0).get<double>(), 6.0)
        << "too wide to say anything";
}

}  // namespace
}  // namespace probebake
