#include "bake/result_record.h"

#include <gtest/gtest.h>

#include "bake_fixture.h"

namespace probebake {
namespace {

ProbeResult some_result() {
    ProbeResult result;
    result.settings.kind = RendererKind::kHybrid;
    result.settings.price = 1.0 / 3.0;
    result.settings.fixed_level = -1;
    result.faces[2].rays = ~uint64_t{0};
    result.faces[5].level_histogram[kMaxDepth] = 300;
    result.pixels[1] = 12;
    result.limited = true;
    result.looks = 3;
    result.certificate.error.mse.value = -1e-300;
    result.certificate.error.ssim = Estimate{.value = 0.5};
    result.certificate.sh = ShAudit{.draws = 7};
    result.certificate.sh->difference[8].z = 0.1;
    result.far_m = std::numeric_limits<double>::infinity();
    result.settings.shifted_grid = true;
    result.settings.least_grid = 4;
    DdgiTile& tile = result.ddgi.emplace();
    tile.irradiance = Image(2, 3);
    tile.irradiance.at(1, 2).b = 1.0f / 3.0f;
    tile.distance = Image(1, 1);
    result.files = {{"cube.exr", {}, 5, "abc"}, {"sh.json", {}, 0, ""}};
    return result;
}

TEST(ResultRecord, ReadsBackBitByBit) {
    Json request = test::small_request(2, {{"psnr_db", 28.0}});
    request["lighting_states"] = {"albedo", "emission"};
    const JobSpec job = read_job(request);
    const std::string record = write_result_record(some_result());
    const std::optional<ProbeResult> read = read_result_record(record, job, 3);
    ASSERT_TRUE(read);
    EXPECT_EQ(write_result_record(*read), record);
    EXPECT_EQ(read->probe, 1U);
    EXPECT_EQ(name_of(read->state), "emission");
    EXPECT_EQ(read->settings, some_result().settings);
    EXPECT_EQ(read->far_m, std::numeric_limits<double>::infinity());
    EXPECT_EQ(read->certificate.error.ssim->value, 0.5);
    EXPECT_FALSE(read->certificate.error.irradiance);
    EXPECT_EQ(read->files[0].sha256, "abc");
    EXPECT_EQ(read->ddgi->irradiance, some_result().ddgi->irradiance);
}

TEST(ResultRecord, RefusesWhatIsNone) {
    const JobSpec job = read_job(test::small_request(1, {{"psnr_db", 28.0}}));
    const std::string record = write_result_record(some_result());
    EXPECT_FALSE(read_result_record("", job, 0));
    for (size_t n = 0; n < record.size(); ++n) {
        EXPECT_FALSE(read_result_record(record.substr(0, n), job, 0)) << n;
    }
    EXPECT_FALSE(read_result_record(record + "x", job, 0));
    std::string newer = record;
    newer[0] = 99;
    EXPECT_FALSE(read_result_record(newer, job, 0));
}

}  // namespace
}  // namespace probebake
