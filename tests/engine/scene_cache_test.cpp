#include "engine/scene_cache.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "io/file.h"
#include "support/sanitized.h"
#include "support/temp_folder.h"

namespace probebake {
namespace {

using namespace std::chrono_literals;

class SceneCacheTest : public testing::Test {
  protected:
    void SetUp() override {
        const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = std::filesystem::path(testing::TempDir()) / ("probebake-cache-" + test);
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    SceneFile scene(const std::string& name, const std::string& generator, int size) const {
        write_file_atomically(folder_ / (name + ".json"),
                              R"({"type": "generator", "generator": ")" + generator +
                                  R"(", "size": )" + std::to_string(size) + "}");
        return read_scene_file(folder_ / (name + ".json"));
    }

    /// A program in the importer's place, whose last argument is the file to write.
    ImportProcess importer(const std::string& script) const {
        ImportProcess process{.program = folder_ / "importer", .scratch = folder_ / "scratch"};
        std::filesystem::create_directories(process.scratch);
        test::write_text(process.program, "#!/bin/sh\nfor into; do :; done\n" + script + "\n");
        ::chmod(process.program.c_str(), 0755);
        return process;
    }
    /// One that decodes every picture to this sky, whole or not at all.
    ImportProcess importer_of(const SkyFile& sky) const {
        save_sky(folder_ / "decoded", sky);
        return importer("cp '" + (folder_ / "decoded").string() +
                        R"(' "$into.$$" && mv "$into.$$" "$into")");
    }

    std::filesystem::path folder_;
    RenderPool pool_{2};
    CancelToken cancel_;
};

TEST_F(SceneCacheTest, LoadsAScenOnceForEverybody) {
    SceneCache cache(pool_, {});
    const SceneFile file = scene("ball", "sphere", 64);
    std::vector<std::shared_ptr<const Scene>> scenes(8);
    {
        std::vector<std::jthread> askers;
        askers.reserve(scenes.size());
        for (auto& slot : scenes) {
            askers.emplace_back([&] { slot = cache.get(file, cancel_); });
        }
    }
    for (const auto& one : scenes) EXPECT_EQ(one, scenes.front());
    EXPECT_EQ(cache.get(file, cancel_), scenes.front());
    EXPECT_EQ(cache.memory_bytes(), scenes.front()->tree.memory_bytes());
}

TEST_F(SceneCacheTest, AChangedFileIsLoadedAnew) {
    SceneCache cache(pool_, {});
    const auto first = cache.get(scene("ball", "sphere", 64), cancel_);
    const auto second = cache.get(scene("ball", "sphere", 128), cancel_);
    EXPECT_NE(first, second);
    EXPECT_LT(first->tree.voxel_count(), second->tree.voxel_count());
}

TEST_F(SceneCacheTest, ScenesThatNobodyHoldsMakeRoom) {
    const SceneFile a = scene("a", "sphere", 128);
    const SceneFile b = scene("b", "box", 128);
    const SceneFile c = scene("c", "stairs", 128);
    SceneCache cache(pool_, {.memory_budget_bytes = 1});
    std::shared_ptr<const Scene> held = cache.get(a, cancel_);
    cache.get(b, cancel_);
    cache.get(c, cancel_);
    // The held one stays, however small the budget; of the others at most the last one.
    EXPECT_EQ(cache.get(a, cancel_), held);
    EXPECT_LE(cache.memory_bytes(),
              held->tree.memory_bytes() + cache.get(c, cancel_)->tree.memory_bytes());
}

TEST_F(SceneCacheTest, AFailureIsToldAndTriedAgain) {
    write_file_atomically(folder_ / "m.vox", std::string("VOX nonsense"));
    write_file_atomically(folder_ / "m.json",
                          std::string(R"({"type": "vox", "file": "m.vox", "voxel_size_m": 1})"));
    const SceneFile file = read_scene_file(folder_ / "m.json");
    SceneCache cache(pool_, {});
    EXPECT_THROW(cache.get(file, cancel_), IoError);
    EXPECT_THROW(cache.get(file, cancel_), IoError);
    EXPECT_EQ(cache.memory_bytes(), 0u);
}

TEST_F(SceneCacheTest, ACancelledJobStopsWaitingAtOnce) {
    const SceneFile file = scene("big", "forest", 512);
    SceneCache cache(pool_, {});
    CancelToken cancel;
    std::jthread canceller([&] {
        std::this_thread::sleep_for(20ms);
        cancel.cancel();
    });
    const auto start = std::chrono::steady_clock::now();
    try {
        cache.get(file, cancel);  // may be done sooner on a fast machine
    } catch (const Cancelled&) {
    }
    EXPECT_LT(std::chrono::steady_clock::now() - start, test::patient(1s));
    EXPECT_GT(cache.get(file, cancel_)->tree.voxel_count(), 0u);  // the load went on
}

SkyFile small_sky() { return {std::make_shared<const Image>(2, 1), std::string(64, 'a')}; }

TEST_F(SceneCacheTest, JobsThatAskForTheSamePictureDoNotDisturbEachOther) {
    test::write_text(folder_ / "sky.hdr", "picture");
    const SkyFile sky = small_sky();
    SceneCache::Options options;
    options.importer = importer_of(sky);
    const SceneCache cache(pool_, options);
    std::atomic<int> wrong = 0;
    {
        std::vector<std::jthread> jobs;
        jobs.reserve(8);
        for (int job = 0; job < 8; ++job) {
            jobs.emplace_back([&] {
                for (int i = 0; i < 20; ++i) {
                    try {
                        wrong += cache.sky(folder_ / "sky.hdr", cancel_).sha256 != sky.sha256;
                    } catch (const IoError&) {
                        ++wrong;
                    }
                }
            });
        }
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_TRUE(std::filesystem::is_empty(options.importer->scratch)) << "a sky is left over";
}

TEST_F(SceneCacheTest, NothingIsLeftOfAPictureThatCannotBeRead) {
    test::write_text(folder_ / "sky.hdr", "picture");
    SceneCache::Options options;
    options.importer = importer(R"(echo nonsense > "$into")");
    EXPECT_THROW(SceneCache(pool_, options).sky(folder_ / "sky.hdr", cancel_), IoError);
    EXPECT_TRUE(std::filesystem::is_empty(options.importer->scratch));
}

TEST_F(SceneCacheTest, APictureThatTheCacheLostIsImportedAgain) {
    test::write_text(folder_ / "sky.hdr", "picture");
    const SkyFile sky = small_sky();
    SceneCache::Options options;
    options.importer = importer_of(sky);
    options.tree_cache_dir = folder_ / "cache";
    std::filesystem::create_directories(*options.tree_cache_dir);
    const SceneCache cache(pool_, options);
    const auto kept = [&] { return *std::filesystem::directory_iterator(*options.tree_cache_dir); };
    cache.sky(folder_ / "sky.hdr", cancel_);
    test::write_text(kept().path(), "damaged");
    EXPECT_EQ(cache.sky(folder_ / "sky.hdr", cancel_).sha256, sky.sha256);
    std::filesystem::remove(kept().path());
    EXPECT_EQ(cache.sky(folder_ / "sky.hdr", cancel_).sha256, sky.sha256);
}

// As many processors as there are may be busy for as long as the clock on the wall allows.
TEST_F(SceneCacheTest, AnImportHasTheTimeOfEveryProcessor) {
    testing::GTEST_FLAG(death_test_style) = "threadsafe";
    const rlim_t processors = std::thread::hardware_concurrency();
    EXPECT_EXIT(
        {
            limit_this_process({.memory_bytes = uint64_t{1} << 33, .time = 100s});
            rlimit time{};
            ::getrlimit(RLIMIT_CPU, &time);
            // First SIGXCPU, which tells why, then SIGKILL.
            const bool right = time.rlim_cur == 100 * processors && time.rlim_max > time.rlim_cur;
            std::_Exit(right ? 7 : 8);
        },
        testing::ExitedWithCode(7), "");
    EXPECT_EXIT(
        {
            limit_this_process({.memory_bytes = uint64_t{1} << 33, .time = 1s});
            std::vector<std::thread> busy;
            for (rlim_t i = 0; i < processors; ++i) {
                busy.emplace_back([] {
                    for (volatile int k = 0;;) k = k + 1;
                });
            }
            for (std::thread& thread : busy) thread.join();
        },
        testing::KilledBySignal(SIGXCPU), "");
}

}  // namespace
}  // namespace probebake
