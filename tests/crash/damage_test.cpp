// C6 and C7: bits flip in files, pages of the database are damaged.
#include <random>
#include <set>

#include "crash_fixture.h"
#include "io/sha256.h"
#include "server/running_service.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using test::Answer;
using test::RunningService;
using test::TempFolder;

void flip(const fs::path& path, uint64_t random) {
    std::string bytes = test::read_text(path);
    const size_t bit = random % (8 * bytes.size());
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
    test::write_text(path, bytes);
}

TEST(Damage, C6_NoFlippedBitIsServedAndEveryFileIsMended) {
    RunningService service;
    Json request = test::costly_request(200, 8);
    request["quality"]["settings"]["leaf_grid"] = 4;
    const std::string id = service.bake(request);
    std::map<std::string, std::string> digests;  // by path
    for (int i = 0; i < 200; ++i) {
        const std::string path =
            "/v1/bakes/" + id + "/probes/p" + std::to_string(i) + "/albedo/cube.exr";
        const std::string tag = service.get(path).header("ETag");
        digests[path] = tag.substr(1, 64);
    }
    std::mt19937_64 random(3);
    std::set<std::string> flipped;
    for (const auto& [path, digest] : digests) {
        if (!flipped.insert(digest).second) continue;  // two probes that see the same
        flip(service.options().data / "files" / digest.substr(0, 2) / digest, random());
    }
    int corrupt = 0;
    int refused = 0;
    for (const auto& [path, digest] : digests) {
        const Answer got = service.get(path);
        refused += got.status == 503 ? 1 : 0;
        corrupt += got.status == 200 && sha256_hex(std::as_bytes(std::span(got.body))) != digest;
    }
    int mended = 0;
    for (const auto& [path, digest] : digests) {
        Answer got = service.get(path);
        for (int i = 0; i < 6000 && got.status == 503; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            got = service.get(path);
        }
        ASSERT_EQ(got.status, 200) << got.body;
        mended += sha256_hex(std::as_bytes(std::span(got.body))) == digest ? 1 : 0;
    }
    std::cout << flipped.size() << " files with a flipped bit, " << refused << " refused at first, "
              << corrupt << " served corrupt, " << mended << " of 200 as they were\n";
    EXPECT_GT(flipped.size(), 150U);
    EXPECT_EQ(corrupt, 0);
    EXPECT_EQ(mended, 200);
    EXPECT_EQ(service.state(id), "SUCCEEDED");
}

TEST(Damage, C7_ADamagedDatabaseIsRefusedOrKeepsItsPromises) {
    if (test::thread_sanitized()) GTEST_SKIP() << "a store is opened in a child of a fork";
    const TempFolder folder;
    const fs::path good = folder.path() / "good";
    const std::string ack = (folder.path() / "ack").string();
    test::Process workload(folder.path() / "workload", {good.string(), ack, "40"},
                           {PROBEBAKE_WORKLOAD, {}});
    ASSERT_EQ(workload.wait(), 0) << workload.err();
    const test::Promises promises = test::read_promises(test::read_text(ack));
    ASSERT_EQ(test::check_store(good, promises, true), test::kKept);
    std::mt19937_64 random(5);
    const auto pages = fs::file_size(good / "probebake.sqlite") / 4096;
    int refused = 0;
    int ended = 0;
    int kept = 0;
    int silent = 0;
    constexpr int kDamages = 60;
    for (int i = 0; i < kDamages; ++i) {
        const fs::path bad = folder.path() / "bad";
        fs::remove_all(bad);
        fs::copy(good, bad, fs::copy_options::recursive);
        std::string bytes = test::read_text(bad / "probebake.sqlite");
        const size_t page = 4096 * (random() % pages);
        for (size_t k = 0; k < 4096; k += 8) {
            const uint64_t noise = random();
            std::memcpy(&bytes[page + k], &noise, sizeof(noise));
        }
        test::write_text(bad / "probebake.sqlite", bytes);
        const int verdict = test::check_store(bad, promises, false);
        refused += verdict == test::kUnusable ? 1 : 0;
        ended += verdict == 74 ? 1 : 0;
        kept += verdict == test::kKept ? 1 : 0;
        silent += verdict == test::kBroken ? 1 : 0;
        EXPECT_LT(verdict, 100) << "a signal";
    }
    std::cout << kDamages << " damaged pages: " << refused << " refused at start, " << ended
              << " found later, " << kept << " harmless, " << silent << " not noticed\n";
    EXPECT_EQ(silent, 0);
    EXPECT_GT(refused, kDamages / 2);
}

}  // namespace
}  // namespace probebake
