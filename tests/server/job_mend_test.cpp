// Files that were damaged on the disk are baked again.
#include "io/io_error.h"
#include "job_fixture.h"

namespace probebake {
namespace {

using namespace std::chrono_literals;

class JobMendTest : public test::JobFixture {
  protected:
    OpenStored open(const std::string& id, const std::string& of,
                    const std::string& name = "cube.exr") {
        return *store_->open_unit_file(manager_->find(id)->sequence, of, "albedo", name);
    }
    /// The number of the unit whose file it is.
    int64_t damage(const std::string& id, const std::string& of,
                   const std::string& name = "cube.exr") {
        const OpenStored stored = open(id, of, name);
        const std::string& digest = stored.file.sha256;
        const std::filesystem::path path =
            folder_.path() / "data/files" / digest.substr(0, 2) / digest;
        std::string bytes = test::read_text(path);
        bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
        test::write_text(path, bytes);
        EXPECT_EQ(open(id, of, name).content, nullptr);
        return stored.unit;
    }
    std::string bake(const Json& request) {
        std::string id = submit(request);
        wait_until_ended(id);
        return id;
    }
    /// A job and its damaged unit, whose mend waits for the scene.
    std::pair<std::string, int64_t> begin_mend() {
        start();
        const std::string id = bake(test::net_request(1));
        const int64_t unit = damage(id, "p0");
        gated_ = true;
        manager_->mend(id, unit);
        wait_for_waiting(1);
        return {id, unit};
    }
    void wait_for_mends(size_t count) {
        for (int i = 0; i < 60000 && mends().size() < count; ++i) std::this_thread::sleep_for(5ms);
        ASSERT_EQ(mends().size(), count);
    }
};

TEST_F(JobMendTest, ADamagedFileIsBakedAgain) {
    start();
    const std::string id = submit(test::grid_request(2, 1, 1));
    wait_until_ended(id);
    for (const auto& [of, name] : std::vector<std::pair<std::string, std::string>>{
             {"g-1-0-0", "cube.exr"}, {"g", "ddgi-distance.exr"}}) {
        const int64_t unit = damage(id, of, name);
        EXPECT_EQ(manager_->mend(id, unit), JobManager::Mend::kUnderWay);
        for (int i = 0; i < 60000 && !open(id, of, name).content; ++i) {
            std::this_thread::sleep_for(5ms);
        }
        EXPECT_TRUE(open(id, of, name).content) << name;
    }
    EXPECT_EQ(manager_->find(id)->state, JobState::kSucceeded);
    EXPECT_EQ(history(id).size(), 3U) << "a terminal state does not change";
}

TEST_F(JobMendTest, WhatCannotBeMendedIsSaidToBeSo) {
    start();
    const std::string id = submit(test::net_request(1));
    wait_until_ended(id);
    found_->text += " ";  // no longer the scene of the job
    manager_->mend(id, 0);
    for (int i = 0; i < 60000 && manager_->mend(id, 0) == JobManager::Mend::kUnderWay; ++i) {
        std::this_thread::sleep_for(5ms);
    }
    EXPECT_EQ(manager_->mend(id, 0), JobManager::Mend::kImpossible);
    EXPECT_EQ(manager_->mend(id, tables::kJobFiles), JobManager::Mend::kImpossible);
}

TEST_F(JobMendTest, WhatAJobNeverHadIsNotBakedToMendTheRest) {
    start();
    // So many that the last ones learn from the first.
    const std::string id = bake_without(test::net_request(32), {1, "p1", "albedo"});
    ASSERT_EQ(units(id).size(), 31U);
    for (const char* of : {"p2", "p31"}) {
        EXPECT_EQ(manager_->mend(id, damage(id, of)), JobManager::Mend::kUnderWay);
        for (int i = 0; i < 60000 && !open(id, of).content; ++i) {
            if (!mends().empty() && !mends().back().empty()) break;
            std::this_thread::sleep_for(5ms);
        }
        EXPECT_TRUE(open(id, of).content) << of << mends().back();
    }
    wait_for_mends(2);
    EXPECT_EQ(mends(), (std::vector<std::string>{"", ""}));
}

TEST_F(JobMendTest, WhoAsksWhileItIsMendedCausesNoSecondMend) {
    const auto [id, unit] = begin_mend();
    EXPECT_EQ(manager_->mend(id, unit), JobManager::Mend::kUnderWay);
    gate_.open();
    wait_for_mends(1);
    std::this_thread::sleep_for(300ms);
    EXPECT_EQ(gate_.waiting(), 1);
    EXPECT_EQ(mends(), std::vector<std::string>{""});
}

TEST_F(JobMendTest, AMendThatTheEndOfTheServiceStopsIsNotToldOf) {
    begin_mend();
    manager_->drain(0ms);
    EXPECT_TRUE(mends().empty());
}

TEST_F(JobMendTest, WhatFailsForNowIsTriedAgain) {
    start();
    const std::string id = bake(test::net_request(1));
    const int64_t unit = damage(id, "p0");
    throw_ = [] { throw IoError("net.vox", "took too long"); };
    manager_->mend(id, unit);
    wait_for_mends(1);
    EXPECT_NE(mends().back().find("too long"), std::string::npos);
    throw_ = {};
    EXPECT_EQ(manager_->mend(id, unit), JobManager::Mend::kUnderWay);
    wait_for_mends(2);
    EXPECT_TRUE(open(id, "p0").content);
}

}  // namespace
}  // namespace probebake
