// What jobs keep when the service ends and starts again, and what is shared between tenants.
#include <algorithm>
#include <barrier>

#include "bake/job_size.h"
#include "job_fixture.h"

namespace probebake {
namespace {

using namespace std::chrono_literals;
using JobRestartTest = test::JobFixture;

/// A report without what no two runs have in common.
Json without_times(Json json) {
    if (json.is_object()) {
        for (const char* key : {"seconds", "wall_seconds", "seconds_to_first_probe",
                                "peak_memory_bytes", "import_seconds", "total_seconds"}) {
            json.erase(key);
        }
    }
    for (auto& value : json) {
        if (value.is_structured()) value = without_times(value);
    }
    return json;
}

TEST_F(JobRestartTest, AStoppedJobGoesOnAtTheNextStartWhereItWas) {
    Json request = test::net_request(12, 16);
    request["lighting_states"] = {"albedo", "emission"};
    request["products"] = {"cube", "sh"};
    start();
    const std::string whole = submit(request);
    wait_until_ended(whole);
    const std::string id = submit(request);
    wait_until(id, [](const JobSnapshot& job) { return job.progress.units_done >= 5; });
    restart();
    const std::vector<StoredUnit> before = units(id);
    EXPECT_LT(before.size(), 24U);
    const JobSnapshot job = wait_until_ended(id);
    EXPECT_EQ(job.state, JobState::kSucceeded);
    EXPECT_EQ(job.progress.units_done, 24U);
    const std::vector<StoredUnit> after = units(id);
    ASSERT_EQ(after.size(), 24U);
    for (size_t i = 0; i < before.size(); ++i) {
        EXPECT_EQ(after[i].name.unit, before[i].name.unit) << "a finished unit was baked again";
    }
    std::map<int64_t, std::string> digests;
    for (const StoredUnit& unit : units(whole)) {
        for (const StoredFile& f : unit.files) digests[unit.name.unit] += f.name + f.sha256;
    }
    for (const StoredUnit& unit : after) {
        std::string digest;
        for (const StoredFile& f : unit.files) digest += f.name + f.sha256;
        EXPECT_EQ(digest, digests[unit.name.unit]);
    }
    const auto text = [&](const std::string& of) {
        const auto content = report(of)->content;
        std::string json(content->size_bytes(), '\0');
        content->read_at(0, json);
        return dump_json(without_times(parse_json(json)));
    };
    EXPECT_EQ(text(id), text(whole)) << "the report of a job that was interrupted is another";
}

TEST_F(JobRestartTest, AtlasesOfAStoppedJobAreThoseOfAnUndisturbedOne) {
    Json request = test::grid_request(3, 2, 2);
    request["lighting_states"] = {"albedo", "emission"};
    start();
    const std::string whole = submit(request);
    wait_until_ended(whole);
    const std::string id = submit(request);
    for (const uint64_t done : {uint64_t{4}, uint64_t{11}, uint64_t{23}}) {
        wait_until(id, [&](const JobSnapshot& job) { return job.progress.units_done >= done; });
        restart();
    }
    const JobSnapshot job = wait_until_ended(id);
    EXPECT_EQ(job.state, JobState::kSucceeded);
    EXPECT_EQ(job.progress.units_done, 24U) << "atlases are none of a job's units";
    std::map<int64_t, std::vector<std::string>> digests;
    for (const std::string& of : {whole, id}) {
        const std::vector<StoredUnit> stored = units(of);
        EXPECT_EQ(stored.size(), 26U);
        for (const StoredUnit& unit : stored) {
            EXPECT_EQ(unit.is_grid, unit.name.unit >= 24);
            std::string text;
            for (const StoredFile& f : unit.files) text += f.name + f.sha256;
            digests[unit.name.unit].push_back(text);
        }
    }
    for (const auto& [unit, both] : digests) EXPECT_EQ(both.front(), both.back()) << unit;
}

TEST_F(JobRestartTest, JobsWaitThroughARestartInTheirOrder) {
    gated_ = true;
    start({.max_running = 1});
    std::vector<std::string> ids;
    ids.reserve(4);
    for (int i = 0; i < 4; ++i) ids.push_back(submit(test::net_request(1)));
    wait_for_waiting(1);
    manager_->cancel(ids[2]);
    restart({.max_running = 1});
    EXPECT_EQ(manager_->find(ids[2])->state, JobState::kCancelled);
    gate_.open();
    std::vector<UnixMs> started;
    for (const size_t i : {0U, 1U, 3U}) {
        const JobSnapshot job = wait_until_ended(ids[i]);
        EXPECT_EQ(job.state, JobState::kSucceeded);
        started.push_back(*job.ended);
    }
    EXPECT_TRUE(std::is_sorted(started.begin(), started.end()));
    restart();
    for (const size_t i : {0U, 1U, 3U}) {
        EXPECT_EQ(manager_->find(ids[i])->state, JobState::kSucceeded);
        EXPECT_TRUE(file(ids[i], "p0")->content);
    }
}

TEST_F(JobRestartTest, AJobWhoseSceneWasChangedFails) {
    gated_ = true;
    start({.max_running = 1});
    submit(test::net_request(1));
    wait_for_waiting(1);
    const std::string id = submit(test::net_request(1));
    found_->text += " ";
    gate_.open();
    const JobSnapshot job = wait_until_ended(id);
    EXPECT_EQ(job.state, JobState::kFailed);
    EXPECT_EQ(job.failure->code, "scene_changed");
    restart();
    EXPECT_EQ(manager_->find(id)->failure->code, "scene_changed");
}

TEST_F(JobRestartTest, APictureOfASkyIsPinnedToo) {
    gated_ = true;
    start({.max_running = 1});
    submit(test::net_request(1));
    wait_for_waiting(1);
    const std::filesystem::path picture = file_.folder / "sky.hdr";
    test::write_text(picture, "one");
    Json request = test::net_request(1);
    request["lighting_states"] = {
        {{"id", "day"}, {"sky", {{"type", "equirect"}, {"file", "sky.hdr"}}}}};
    const std::string id = submit(request);
    test::write_text(picture, "two");
    gate_.open();
    EXPECT_EQ(wait_until_ended(id).failure->code, "scene_changed");
}

TEST_F(JobRestartTest, WhatAJobMayWriteStaysPromisedThroughARestart) {
    gated_ = true;
    start({.max_running = 1});
    const Json request = test::net_request(3, 64);
    const std::string running = submit(request);
    const std::string queued = submit(test::net_request(5, 32));
    wait_for_waiting(1);
    const uint64_t promised = manager_->promised_bytes();
    EXPECT_EQ(promised, size_of_job(read_job(request)).output_bytes +
                            size_of_job(read_job(test::net_request(5, 32))).output_bytes);
    restart({.max_running = 1});
    EXPECT_EQ(manager_->promised_bytes(), promised);
    gate_.open();
    wait_until_ended(running);
    wait_until_ended(queued);
    EXPECT_EQ(manager_->promised_bytes(), 0U);
}

TEST_F(JobRestartTest, AKeyStandsForOneJob) {
    start();
    JobRequest request{.spec = read_job(test::net_request(1)), .scene = file_};
    request.idempotency_key = "k";
    request.sha256 = "a";
    const JobManager::Submitted first = manager_->submit(request);
    EXPECT_FALSE(first.replayed);
    wait_until_ended(first.job.id);
    restart();
    const JobManager::Submitted second = manager_->submit(request);
    EXPECT_TRUE(second.replayed);
    EXPECT_EQ(second.job.id, first.job.id);
    request.sha256 = "b";
    EXPECT_THROW(manager_->submit(request), KeyReused);
    EXPECT_EQ(manager_->list({}).size(), 1U);
}

TEST_F(JobRestartTest, TenantsShareTheThreadsAndHaveAQuota) {
    gated_ = true;
    start({.max_running = 2, .max_per_tenant = 4});
    const auto submit_as = [&](const std::string& tenant) {
        return manager_
            ->submit({.spec = read_job(test::net_request(1)), .scene = file_, .tenant = tenant})
            .job.id;
    };
    std::vector<std::string> greedy;
    greedy.reserve(4);
    for (int i = 0; i < 4; ++i) greedy.push_back(submit_as("a"));
    wait_for_waiting(2);
    try {
        submit_as("a");
        FAIL() << "a job beyond the quota was taken";
    } catch (const ServiceBusy& busy) {
        EXPECT_EQ(busy.code(), "quota");
    }
    const std::string modest = submit_as("b");
    manager_->cancel(greedy[0]);  // a thread is free: whose turn is it?
    wait_until(modest, [](const JobSnapshot& job) { return job.state == JobState::kRunning; });
    EXPECT_EQ(manager_->find(greedy[2])->state, JobState::kQueued);
    EXPECT_EQ(manager_->list({.tenant = "b"}).size(), 1U);
    gate_.open();
}

TEST_F(JobRestartTest, OfATenantsJobsTheMostImportantIsNextAfterARestartToo) {
    gated_ = true;
    start({.max_running = 1});
    const auto submit_with = [&](int priority) {
        Json request = test::net_request(1);
        request["priority"] = priority;
        return submit(request);
    };
    submit_with(0);
    wait_for_waiting(1);
    const std::string low = submit_with(-5);
    const std::string usual = submit_with(0);
    const std::string high = submit_with(5);
    gate_.open();
    restart({.max_running = 1});
    for (const std::string& id : {low, usual, high}) wait_until_ended(id);
    EXPECT_LE(*manager_->find(high)->ended, *manager_->find(usual)->started);
    EXPECT_LE(*manager_->find(usual)->ended, *manager_->find(low)->started);
}

TEST_F(JobRestartTest, AClockThatJumpsForgetsNoKey) {
    std::atomic<UnixMs> jump{0};
    start({.key_time = 1s, .wall_clock = [&] { return unix_ms_now() + jump; }});
    JobRequest request{.spec = read_job(test::net_request(1)), .scene = file_};
    request.idempotency_key = "k";
    const std::string id = manager_->submit(request).job.id;
    jump = UnixMs{2} * 24 * 3600 * 1000;
    std::this_thread::sleep_for(2500ms);  // time for the keeper of the house to be wrong
    EXPECT_EQ(manager_->submit(request).job.id, id);
    jump = 0;
    for (int i = 0; i < 6000 && manager_->submit(request).replayed; ++i) {
        std::this_thread::sleep_for(10ms);
    }
    EXPECT_EQ(manager_->list({}).size(), 2U) << "a key is known for its time only";
}

TEST_F(JobRestartTest, AKeyThatComesTwiceAtOnceIsOneJob) {
    gated_ = true;
    start({.max_queued = 1000, .max_per_tenant = 1000});
    constexpr size_t kJobs = 100;
    std::atomic<int> refused{0};
    for (size_t i = 0; i < kJobs; ++i) {
        std::barrier together(4);
        std::vector<std::jthread> clients;
        clients.reserve(4);
        for (int k = 0; k < 4; ++k) {
            clients.emplace_back([&] {
                JobRequest request{.spec = read_job(test::net_request(1)), .scene = file_};
                request.idempotency_key = "k" + std::to_string(i);
                together.arrive_and_wait();
                try {
                    manager_->submit(request);
                } catch (const ServiceBusy&) {
                    ++refused;
                }
            });
        }
    }
    EXPECT_EQ(refused, 0);
    EXPECT_EQ(manager_->list({.count = 1000}).size(), kJobs);
}

TEST_F(JobRestartTest, AQuotaHoldsForJobsThatComeAtOnce) {
    gated_ = true;
    start({.max_queued = 100, .max_per_tenant = 3});
    std::barrier together(16);
    std::vector<std::jthread> clients;
    clients.reserve(16);
    for (int k = 0; k < 16; ++k) {
        clients.emplace_back([&] {
            together.arrive_and_wait();
            try {
                submit(test::net_request(1));
            } catch (const ServiceBusy& busy) {
                EXPECT_EQ(busy.code(), "quota");
            }
        });
    }
    clients.clear();
    EXPECT_EQ(manager_->list({}).size(), 3U);
}

TEST_F(JobRestartTest, JobsThatEndAtAStartAreToldOf) {
    gated_ = true;
    start();
    const std::string poison = submit(test::net_request(1));
    const std::string cancelled = submit(test::net_request(1));
    wait_for_waiting(2);
    const int64_t sequence = manager_->find(poison)->sequence;
    store_->request_cancel(manager_->find(cancelled)->sequence);
    for (int crash = 0; crash < 3; ++crash) {
        manager_.reset();
        store_->start(sequence, 1);
        store_.reset();
        store_.emplace(folder_.path() / "data", JobStore::Options{});
    }
    start();
    EXPECT_EQ(manager_->find(poison)->failure->code, "poison");
    EXPECT_EQ(history(poison).back(), JobState::kFailed);
    restart();
    EXPECT_EQ(std::count(history_[poison].begin(), history_[poison].end(), JobState::kFailed), 1);
}

TEST_F(JobRestartTest, AUnitThatFailsLeavesTheOthersRunning) {
    start();
    const Json request = test::net_request(3);
    const std::string id = submit(request);
    wait_until_ended(id);
    const std::string poisoned = bake_without(request, {1, "p1", "albedo"});
    const JobSnapshot job = *manager_->find(poisoned);
    EXPECT_EQ(job.state, JobState::kFailed);
    EXPECT_EQ(job.failure->code, "units");
    ASSERT_EQ(job.failure->issues.size(), 1U);
    EXPECT_EQ(job.failure->issues[0].pointer, "/probes/p1/albedo");
    EXPECT_EQ(unit_count(poisoned), 2U);
    EXPECT_EQ(file(poisoned, "p2")->file.sha256, file(id, "p2")->file.sha256);
}

}  // namespace
}  // namespace probebake
