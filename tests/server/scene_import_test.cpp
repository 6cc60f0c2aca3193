// Scenes of other programs' files are imported by a process of its own, and what it dies of is
// told.
#include <fcntl.h>

#include <fstream>
#include <thread>

#include "engine/scene_cache.h"
#include "running_service.h"
#include "scene/gltf_writer.h"
#include "scene_import_fixture.h"
#include "support/sanitized.h"

namespace probebake {
namespace {

using namespace std::chrono_literals;

using test::SceneImportTest;

TEST_F(SceneImportTest, GivesTheSceneThatThisProcessWouldMake) {
    const SceneFile file = scene(test::every_chunk().file());
    SceneCache::Options options;
    options.importer = process();
    SceneCache cache(pool_, options);
    const auto imported = cache.get(file, cancel_);
    const Scene own = load_scene(file);
    EXPECT_EQ(imported->sha256, own.sha256);
    EXPECT_EQ(imported->tree.voxel_count(), own.tree.voxel_count());
    EXPECT_EQ(imported->corner_m, own.corner_m);
    EXPECT_EQ(imported->warnings, own.warnings);
    EXPECT_TRUE(std::filesystem::is_empty(path("scratch"))) << "a tree is left over";
}

TEST_F(SceneImportTest, AHostileFileKillsAtMostTheChild) {
    test::Bytes cut = test::every_chunk().file();
    cut.resize(cut.size() / 2);
    const SceneFile file = scene(cut);
    EXPECT_NE(refusal(file, process()).find("model.vox"), std::string::npos)
        << refusal(file, process());
    EXPECT_EQ(refusal(file, process("kill -SEGV $$")), "model: its import crashed (signal 11)");
    EXPECT_EQ(refusal(file, process("kill -KILL $$")), "model: its import crashed (signal 9)");
    EXPECT_EQ(refusal(file, process("printf 'bad\\033[1m file\\n' >&2; exit 3")),
              "model: bad [1m file");
    EXPECT_EQ(refusal(file, process("exit 1")), "model: its import failed");
    // More than the pipe holds must not make it wait for us.
    EXPECT_EQ(refusal(file, process("head -c 1000000 /dev/zero | tr '\\0' x >&2; exit 1")).size(),
              7U + 1000U);
}

TEST_F(SceneImportTest, MemoryAndTimeAreLimited) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers need more address space than any limit leaves";
#endif
    std::vector<test::VoxelRow> block;
    block.reserve(size_t{60} * 60 * 60);
    for (int i = 0; i < 60 * 60 * 60; ++i) {
        block.push_back({static_cast<uint8_t>(i % 60), static_cast<uint8_t>(i / 60 % 60),
                         static_cast<uint8_t>(i / 3600), 1});
    }
    const SceneFile file = scene(test::VoxWriter().model({60, 60, 60}, block).file());
    ImportProcess small = process();
    small.limits.memory_bytes = uint64_t{1} << 20;
    EXPECT_EQ(refusal(file, small), "model: its import needs more memory than it may");
    ImportProcess slow = process("sleep 60");
    slow.limits.time = 1s;
    EXPECT_LT(test::seconds_of([&] {
                  EXPECT_EQ(refusal(file, slow), "model: its import took more time than it may");
              }),
              20.0);
}

TEST_F(SceneImportTest, FilesAreLimitedToo) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer's own report of the signal is another end";
#endif
    testing::GTEST_FLAG(death_test_style) = "threadsafe";
    const std::string file = path("large").string();
    const ImportLimits limits{.memory_bytes = uint64_t{256} << 20, .time = 60s};
    EXPECT_EXIT(
        {
            limit_this_process(limits);
            std::ofstream out(file);
            const std::string megabyte(size_t{1} << 20, 'x');
            for (int i = 0; i < 300; ++i) out << megabyte << std::flush;
        },
        testing::KilledBySignal(SIGXFSZ), "");
    EXPECT_EXIT(
        {
            limit_this_process(limits);
            for (int i = 0; i < 100; ++i) {
                if (::open("/dev/null", O_RDONLY) < 0) std::_Exit(errno == EMFILE ? 7 : 8);
            }
        },
        testing::ExitedWithCode(7), "");
    EXPECT_EQ(refusal(scene(test::every_chunk().file()), process("kill -XFSZ $$")),
              "model: its import wrote more than it may");
}

TEST_F(SceneImportTest, ItHasNoFileOfTheService) {
    const SceneFile file = scene(test::every_chunk().file());
    // Standard input, output and error, and the folder that is being listed.
    EXPECT_EQ(refusal(file, process("ls /proc/self/fd | wc -l >&2; exit 1")), "model: 4");
}

TEST_F(SceneImportTest, DamagedGlbFilesEndWithAReason) {
    test::write_text(path("box.json"), R"({"type": "gltf", "file": "box.glb", "resolution": 8})");
    expect_damage_is_told("box.json", "box.glb", test::gltf_triangle().binary());
}

TEST_F(SceneImportTest, ACancelledImportEndsAtOnce) {
    const SceneFile file = scene(test::every_chunk().file());
    std::jthread canceller([&] {
        std::this_thread::sleep_for(200ms);
        cancel_.cancel();
    });
    EXPECT_LT(test::seconds_of([&] {
                  EXPECT_THROW(import_in_process(process("sleep 60"), file, path("cache"), cancel_),
                               Cancelled);
              }),
              10.0);
}

TEST_F(SceneImportTest, PicturesOfSkiesAreDecodedElsewhere) {
    const std::filesystem::path own = PROBEBAKE_SOURCE_DIR "/configs/scenes/dusk.hdr";
    const SkyFile expected = read_sky_file(own);
    for (const bool kept : {false, true}) {
        SceneCache::Options options;
        options.importer = process();
        std::filesystem::create_directories(options.importer->scratch);
        if (kept) options.tree_cache_dir = path("cache");
        std::filesystem::create_directories(path("cache"));
        const SceneCache cache(pool_, options);
        for (int i = 0; i < 2; ++i) {
            const SkyFile sky = cache.sky(own, cancel_);
            EXPECT_EQ(*sky.image, *expected.image);
            EXPECT_EQ(sky.sha256, expected.sha256);
        }
        EXPECT_TRUE(std::filesystem::is_empty(options.importer->scratch)) << "a sky is left over";
    }
    SceneCache::Options options;
    options.importer = process("kill -SEGV $$");
    const SceneCache cache(pool_, options);
    EXPECT_THROW(cache.sky(own, cancel_), IoError);
}

TEST_F(SceneImportTest, LightIsKeptBetweenRunsAndChangesNothing) {
    const std::filesystem::path cache = path("cache");
    Json request = test::net_request(1);
    request["lighting_states"] = {
        {{"id", "day"}, {"sun", {{"direction", {1, 2, 1}}, {"irradiance_w_m2", {3, 3, 3}}}}}};
    std::vector<Json> reports;
    std::vector<std::string> cubes;
    for (int run = 0; run < 2; ++run) {
        const test::RunningService service(
            [&](ServiceOptions& options) { options.cache.tree_cache_dir = cache; });
        const std::string bake = "/v1/bakes/" + service.bake(request);
        reports.push_back(service.get(bake + "/report").json().at("states").at(0).at("lighting"));
        const Json row = service.get(bake + "/probes").json().at("rows").at(0);
        cubes.push_back(row.at("files").at(0).at("sha256"));
    }
    EXPECT_EQ(reports[0].at("from_cache"), false);
    EXPECT_EQ(reports[1].at("from_cache"), true);
    EXPECT_EQ(reports[0].at("sun_rays"), reports[1].at("sun_rays"));
    EXPECT_EQ(cubes[0], cubes[1]);
}

TEST_F(SceneImportTest, AJobWhoseSceneIsImportedIsCancelledWithinASecond) {
    test::RunningService service(
        [&](ServiceOptions& options) { options.cache.importer = process("exec sleep 60"); });
    write_file_atomically(service.scenes() / "model.vox", test::every_chunk().file());
    test::write_text(service.scenes() / "model.json",
                     R"({"type": "vox", "file": "model.vox", "voxel_size_m": 0.5})");
    Json request = test::net_request(1);
    request["scene"] = "model";
    const std::string id = service.submit(request);
    service.wait(id, [](const Json& bake) { return bake["state"] == "RUNNING"; });
    std::this_thread::sleep_for(200ms);  // the child has begun
    EXPECT_LT(test::seconds_of([&] {
                  EXPECT_EQ(service.post("/v1/bakes/" + id + ":cancel").status, 202);
                  EXPECT_EQ(service.wait_until_ended(id).at("state"), "CANCELLED");
              }),
              test::patient(1.0));
}

TEST_F(SceneImportTest, TheJobFailsWithTheReasonAndTheServiceGoesOn) {
    test::RunningService service(
        [&](ServiceOptions& options) { options.cache.importer = process("kill -SEGV $$"); });
    const std::filesystem::path scenes = service.options().scenes;
    write_file_atomically(scenes / "model.vox", test::every_chunk().file());
    test::write_text(scenes / "model.json",
                     R"({"type": "vox", "file": "model.vox", "voxel_size_m": 0.5})");
    Json request = test::net_request(1);
    request["scene"] = "model";
    const Json bake = service.wait_until_ended(service.submit(request));
    EXPECT_EQ(bake.at("state"), "FAILED");
    EXPECT_EQ(bake.at("error").at("type"), "urn:probebake:scene");
    EXPECT_EQ(bake.at("error").at("detail"), "model: its import crashed (signal 11)");
    service.bake(test::net_request(1));
}

}  // namespace
}  // namespace probebake
