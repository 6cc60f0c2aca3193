#include "store/job_store.h"

#include "store_fixture.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using JobStoreTest = test::StoreTest;
using test::new_file;
using test::text_of;

TEST_F(JobStoreTest, WhatWasAcceptedIsThereAfterARestart) {
    NewJob job = new_job();
    job.request = R"({"scene": "net"})";
    const int64_t first = store_->insert(job).sequence;
    const int64_t second = insert();
    EXPECT_LT(first, second);
    reopen();
    ASSERT_EQ(store_->jobs().size(), 2U);
    const StoredJob found = find(first);
    EXPECT_EQ(found.id, job.id);
    EXPECT_EQ(found.state, JobState::kQueued);
    EXPECT_EQ(found.scene_sha256, job.scene_sha256);
    EXPECT_EQ(found.units, 3U);
    EXPECT_EQ(found.most_bytes, 50'000U);
    EXPECT_EQ(store_->request_of(first), job.request);
    EXPECT_LT(second, insert()) << "numbers are not used twice";
}

TEST_F(JobStoreTest, KeepsWhatWasPublishedAndNothingElse) {
    const int64_t job = running();
    publish(job, 1, "abc");
    publish(job, 0, "def");
    const auto found = store_->open_unit_file(job, "p1", "albedo", "cube.exr");
    ASSERT_TRUE(found && found->content);
    EXPECT_EQ(text_of(*found->content), "abc");
    EXPECT_EQ(found->unit, 1);
    EXPECT_EQ(test::read_text(path_of("abc")), "abc");
    for (const auto& [probe, state, name] :
         std::vector<std::array<std::string, 3>>{{"p1", "albedo", "aux.exr"},
                                                 {"p1", "emission", "cube.exr"},
                                                 {"p2", "albedo", "cube.exr"},
                                                 {"..", "albedo", "cube.exr"},
                                                 {"p1", "albedo", "../../lock"},
                                                 {"", "", ""}}) {
        EXPECT_FALSE(store_->open_unit_file(job, probe, state, name)) << probe << state << name;
    }
    EXPECT_FALSE(store_->open_unit_file(job + 1, "p1", "albedo", "cube.exr"));
    // In the order of publication.
    const std::vector<StoredUnit> units = store_->published(job, 0, 5);
    ASSERT_EQ(units.size(), 2U);
    EXPECT_EQ(units[0].name.probe, "p1");
    EXPECT_EQ(units[1].name.probe, "p0");
    EXPECT_EQ(store_->published(job, 1, 5).size(), 1U);
    EXPECT_TRUE(store_->published(job, ~uint64_t{0}, 5).empty());
    EXPECT_EQ(find(job).bytes, 2 * 4096U);
}

TEST_F(JobStoreTest, AJobThatRanGoesOnWithWhatItHad) {
    const int64_t job = running();
    publish(job, 0, "abc");
    store_->begin_unit(job, unit(1));
    reopen();
    EXPECT_EQ(state(job), JobState::kQueued);
    EXPECT_EQ(find(job).units_done, 1U);
    const StoredUnits units = store_->units_of(job);
    ASSERT_EQ(units.finished.size(), 1U);
    EXPECT_EQ(units.finished[0], (std::pair<int64_t, std::string>(0, "record")));
    EXPECT_EQ(units.suspects, std::vector<int64_t>{1});
    EXPECT_EQ(store_->begin_unit(job, unit(0)), 0) << "a finished unit is not begun again";
    EXPECT_TRUE(store_->start(job, 9));
    EXPECT_EQ(find(job).started, 2) << "the first time counts";
}

TEST_F(JobStoreTest, ALateAttemptIsFencedOff) {
    const int64_t job = running();
    const int64_t late = store_->begin_unit(job, unit(0));
    const int64_t current = store_->begin_unit(job, unit(0));
    EXPECT_EQ(late + 1, current);
    EXPECT_THROW(store_->publish(job, 0, late, "r", {new_file("cube.exr", "late")}), IoError);
    EXPECT_FALSE(store_->open_unit_file(job, "p0", "albedo", "cube.exr"));
    store_->publish(job, 0, current, "r", {new_file("cube.exr", "abc")});
    EXPECT_THROW(store_->publish(job, 0, current, "r", {new_file("cube.exr", "abc")}), IoError)
        << "published twice";
    EXPECT_EQ(find(job).units_done, 1U);
}

TEST_F(JobStoreTest, AUnitIsPoisonAfterThreeCrashes) {
    const int64_t job = running();
    publish(job, 0, "abc");
    for (int crash = 1; crash <= 3; ++crash) {
        store_->begin_unit(job, unit(1));
        reopen();
        EXPECT_EQ(state(job), JobState::kQueued);
        EXPECT_EQ(store_->units_of(job).suspects.size(), crash < 3 ? 1U : 0U);
        EXPECT_EQ(store_->units_of(job).poison.size(), crash < 3 ? 0U : 1U);
        store_->start(job, 2);
    }
}

TEST_F(JobStoreTest, AJobIsPoisonAfterThreeCrashesBetweenItsUnits) {
    const int64_t job = running();
    for (int crash = 1; crash <= 3; ++crash) {
        reopen();
        EXPECT_EQ(state(job), crash < 3 ? JobState::kQueued : JobState::kFailed);
        store_->start(job, 2);
    }
    EXPECT_NE(find(job).failure.value_or("").find("poison"), std::string::npos);
}

TEST_F(JobStoreTest, AFinishedUnitForgivesAJobsCrashes) {
    const int64_t job = running();
    for (int i = 0; i < 6; ++i) {
        reopen();
        ASSERT_EQ(state(job), JobState::kQueued) << i;
        store_->start(job, 2);
        if (i % 2 == 1) publish(job, i, "abc");
    }
}

TEST_F(JobStoreTest, AShutdownCountsNoCrash) {
    const int64_t job = running();
    for (int i = 0; i < 5; ++i) {
        store_->begin_unit(job, unit(1));
        store_->interrupt(job);
        reopen();
        EXPECT_EQ(state(job), JobState::kQueued);
        EXPECT_TRUE(store_->units_of(job).suspects.empty());
        store_->start(job, 2);
    }
}

TEST_F(JobStoreTest, WhatWasUnderWayWhenAJobEndedIsNotRecovered) {
    const int64_t job = running();
    store_->begin_unit(job, unit(1));
    end(job, JobState::kCancelled);
    reopen();
    EXPECT_EQ(store_->recovered().units, 0);
    EXPECT_TRUE(store_->units_of(job).suspects.empty());
}

TEST_F(JobStoreTest, ATerminalStateNeverChanges) {
    const int64_t job = running();
    EXPECT_TRUE(end(job, JobState::kFailed));
    EXPECT_FALSE(end(job, JobState::kSucceeded));
    store_->request_cancel(job);
    store_->interrupt(job);
    EXPECT_FALSE(store_->start(job, 5));
    reopen();
    EXPECT_EQ(state(job), JobState::kFailed);
}

TEST_F(JobStoreTest, ACancelThatWasPromisedIsKept) {
    const int64_t job = running();
    store_->request_cancel(job);
    EXPECT_EQ(state(job), JobState::kCancelling);
    reopen();
    EXPECT_EQ(state(job), JobState::kCancelled);
    EXPECT_TRUE(find(job).ended);
}

TEST_F(JobStoreTest, AKeyStandsForOneRequest) {
    NewJob job = new_job();
    job.idempotency_key = "k";
    EXPECT_FALSE(store_->insert(job).replay_of);
    NewJob again = job;
    again.id = new_job_id();
    reopen();
    const tables::Inserted same = store_->insert(again);
    EXPECT_EQ(same.replay_of, job.id);
    EXPECT_FALSE(same.conflict);
    again.request_sha256 = "other";
    EXPECT_TRUE(store_->insert(again).conflict);
    again.tenant = "another";
    EXPECT_FALSE(store_->insert(again).replay_of) << "keys belong to tenants";
    EXPECT_EQ(store_->jobs().size(), 2U);
    store_->forget_keys(job.created + 1);
    again.tenant = job.tenant;
    again.id = new_job_id();
    EXPECT_FALSE(store_->insert(again).replay_of);
}

TEST_F(JobStoreTest, ADamagedFileIsNotGivenOutAndCanBeMended) {
    const int64_t job = running();
    publish(job, 0, "abc");
    end(job);
    test::write_text(path_of("abc"), "abd");
    auto found = store_->open_unit_file(job, "p0", "albedo", "cube.exr");
    ASSERT_TRUE(found);
    EXPECT_EQ(found->content, nullptr);
    EXPECT_THROW(store_->publish(job, 0, 0, {}, {new_file("cube.exr", "xyz")}), IoError);
    store_->publish(job, 0, 0, {}, {new_file("cube.exr", "abc")});
    found = store_->open_unit_file(job, "p0", "albedo", "cube.exr");
    ASSERT_TRUE(found->content);
    EXPECT_EQ(text_of(*found->content), "abc");
    fs::remove(path_of("abc"));
    EXPECT_EQ(store_->open_unit_file(job, "p0", "albedo", "cube.exr")->content, nullptr);
}

TEST_F(JobStoreTest, ADeletedJobTakesItsFilesWithIt) {
    const int64_t job = running();
    const int64_t other = running();
    publish(job, 0, "mine");
    publish(job, 1, "ours");
    publish(other, 0, "ours");
    end(job);
    const auto open = store_->open_unit_file(job, "p0", "albedo", "cube.exr");
    store_->remove(job);
    EXPECT_FALSE(store_->open_unit_file(job, "p0", "albedo", "cube.exr"));
    while (store_->tidy()) {
    }
    EXPECT_FALSE(fs::exists(path_of("mine")));
    EXPECT_TRUE(fs::exists(path_of("ours"))) << "another job has the same file";
    EXPECT_EQ(text_of(*open->content), "mine") << "a download that began goes on";
    reopen();
    EXPECT_EQ(store_->jobs().size(), 1U);
}

TEST_F(JobStoreTest, AnExpiredJobIsRememberedADeletedOneIsNot) {
    const int64_t expired = running();
    const int64_t deleted = running();
    publish(expired, 0, "mine");
    const std::string expired_id = find(expired).id;
    const std::string deleted_id = find(deleted).id;
    end(expired);
    end(deleted);
    EXPECT_FALSE(store_->tenant_of_expired(expired_id));
    store_->expire(expired);
    store_->remove(deleted);
    while (store_->tidy()) {
    }
    EXPECT_FALSE(fs::exists(path_of("mine")));
    reopen();
    EXPECT_TRUE(store_->jobs().empty());
    EXPECT_EQ(store_->tenant_of_expired(expired_id), "local");
    EXPECT_FALSE(store_->tenant_of_expired(deleted_id));
}

TEST_F(JobStoreTest, AKeyOutlivesItsExpiredJob) {
    NewJob job = new_job();
    job.idempotency_key = "k";
    const int64_t sequence = store_->insert(job).sequence;
    end(sequence, JobState::kCancelled);
    store_->expire(sequence);
    reopen();
    NewJob again = job;
    again.id = new_job_id();
    EXPECT_EQ(store_->insert(again).replay_of, job.id);
    again.request_sha256 = "other";
    EXPECT_TRUE(store_->find_key(again)->conflict);
    again.tenant = "another";
    EXPECT_FALSE(store_->find_key(again));
    EXPECT_TRUE(store_->jobs().empty());
    store_->forget_keys(job.created + 1);
    again.tenant = job.tenant;
    EXPECT_FALSE(store_->insert(again).replay_of);
}

TEST_F(JobStoreTest, FilesThatNobodyNamesAreSweptAway) {
    const int64_t job = running();
    publish(job, 0, "named");
    store_.reset();
    test::write_text(path_of("orphan"), "orphan");
    test::write_text(data() / "temporary" / "12", "half a file");
    open();
    EXPECT_FALSE(fs::exists(data() / "temporary" / "12"));
    while (store_->tidy()) {
    }
    EXPECT_FALSE(fs::exists(path_of("orphan")));
    EXPECT_TRUE(fs::exists(path_of("named")));
}

TEST_F(JobStoreTest, WritesThatComeTogetherAreCommittedTogether) {
    constexpr int kThreads = 16;
    constexpr int kJobs = 20;
    {
        std::vector<std::jthread> threads;
        threads.reserve(kThreads);
        for (int i = 0; i < kThreads; ++i) {
            threads.emplace_back([&] {
                for (int k = 0; k < kJobs; ++k) insert();
            });
        }
    }
    const JobStore::Counts counts = store_->counts();
    EXPECT_EQ(counts.writes, static_cast<uint64_t>(kThreads * kJobs));
    EXPECT_LT(counts.commits, counts.writes / 2);
    RecordProperty("writes_per_commit", std::to_string(static_cast<double>(counts.writes) /
                                                       static_cast<double>(counts.commits)));
    reopen();
    EXPECT_EQ(store_->jobs().size(), static_cast<size_t>(kThreads * kJobs));
}

TEST_F(JobStoreTest, AFailedWriteTakesNoOtherWithIt) {
    const NewJob job = new_job();
    store_->insert(job);
    std::atomic<int> failures{0};
    {
        std::vector<std::jthread> threads;
        threads.reserve(8);
        for (int i = 0; i < 8; ++i) {
            threads.emplace_back([&, i] {
                try {
                    if (i % 2 == 0) {
                        insert();
                    } else {
                        store_->insert(job);  // the same id
                    }
                } catch (const IoError&) {
                    ++failures;
                }
            });
        }
    }
    EXPECT_EQ(failures, 4);
    EXPECT_EQ(store_->jobs().size(), 5U);
}

}  // namespace
}  // namespace probebake
