#include "jobs/job_manager.h"

#include <new>

#include "io/io_error.h"
#include "job_fixture.h"
#include "support/sanitized.h"

namespace probebake {
namespace {

using namespace std::chrono_literals;
using JobManagerTest = test::JobFixture;

TEST_F(JobManagerTest, BakesAJobToItsReport) {
    start();
    const std::string id = submit(test::net_request(3));
    const JobSnapshot job = wait_until_ended(id);
    EXPECT_EQ(job.state, JobState::kSucceeded);
    EXPECT_EQ(job.progress.units_done, 3U);
    EXPECT_EQ(job.progress.units, 3U);
    ASSERT_TRUE(job.started && job.ended);
    EXPECT_LE(job.created, *job.started);
    EXPECT_LE(*job.started, *job.ended);
    EXPECT_GT(job.progress.seconds, 0.0);
    EXPECT_FALSE(job.failure);
    EXPECT_EQ(history(id),
              (std::vector<JobState>{JobState::kQueued, JobState::kRunning, JobState::kSucceeded}));
    EXPECT_NE(report(id)->content, nullptr);
    const auto rows = store_->open_unchecked(job.sequence, kRowFile);
    EXPECT_EQ(read_rows(*rows->content, 0, 10)->rows.size(), 3U);
    EXPECT_EQ(unit_count(id), 3U);
}

TEST_F(JobManagerTest, ATerminalStateNeverChanges) {
    start();
    const std::string id = submit(test::net_request(1));
    wait_until_ended(id);
    EXPECT_EQ(manager_->cancel(id)->state, JobState::kSucceeded);
    manager_->drain(0ms);
    EXPECT_EQ(manager_->find(id)->state, JobState::kSucceeded);
    EXPECT_EQ(history(id).size(), 3U);
}

TEST_F(JobManagerTest, RunsSoManyAtOnceAndQueuesSoMany) {
    gated_ = true;
    start({.max_running = 2, .max_queued = 3});
    std::vector<std::string> ids;
    ids.reserve(5);
    for (int i = 0; i < 2; ++i) ids.push_back(submit(test::net_request(1)));
    wait_for_waiting(2);
    for (int i = 0; i < 3; ++i) ids.push_back(submit(test::net_request(1)));
    try {
        submit(test::net_request(1));
        FAIL() << "a job beyond the queue was taken";
    } catch (const ServiceBusy& busy) {
        EXPECT_EQ(busy.code(), "queue-full");
    }
    EXPECT_EQ(gate_.waiting(), 2);
    EXPECT_EQ(manager_->list({.state = JobState::kRunning}).size(), 2U);
    EXPECT_EQ(manager_->list({.state = JobState::kQueued}).size(), 3U);
    gate_.open();
    for (const std::string& id : ids) EXPECT_EQ(wait_until_ended(id).state, JobState::kSucceeded);
    submit(test::net_request(1));  // there is room again
}

TEST_F(JobManagerTest, AQueuedJobIsCancelledAtOnce) {
    gated_ = true;
    start({.max_running = 1});
    submit(test::net_request(1));
    wait_for_waiting(1);
    const std::string id = submit(test::net_request(1));
    const std::string other = submit(test::net_request(1));
    EXPECT_EQ(manager_->cancel(id)->state, JobState::kCancelled);
    EXPECT_EQ(manager_->cancel(id)->state, JobState::kCancelled);
    EXPECT_FALSE(manager_->find(id)->started);
    EXPECT_TRUE(manager_->find(id)->ended);
    gate_.open();
    EXPECT_EQ(wait_until_ended(other).state, JobState::kSucceeded);
    EXPECT_EQ(history(id), (std::vector<JobState>{JobState::kQueued, JobState::kCancelled}));
}

TEST_F(JobManagerTest, AJobThatWaitsForItsSceneIsCancelledWithinASecond) {
    gated_ = true;
    start();
    const std::string id = submit(test::net_request(1));
    wait_for_waiting(1);
    const auto start_time = std::chrono::steady_clock::now();
    EXPECT_EQ(manager_->cancel(id)->state, JobState::kCancelling);
    wait_until_ended(id);
    EXPECT_LT(std::chrono::steady_clock::now() - start_time, test::patient(1s));
    EXPECT_EQ(history(id), (std::vector<JobState>{JobState::kQueued, JobState::kRunning,
                                                  JobState::kCancelling, JobState::kCancelled}));
}

TEST_F(JobManagerTest, ARunningJobIsCancelledWithinASecondAndKeepsItsProbes) {
    start();
    const std::string id = submit(test::costly_request(5000, 8));
    wait_until(id, [](const JobSnapshot& job) { return job.progress.units_done >= 3; });
    const auto start_time = std::chrono::steady_clock::now();
    manager_->cancel(id);
    const JobSnapshot job = wait_until_ended(id);
    EXPECT_LT(std::chrono::steady_clock::now() - start_time, test::patient(1s));
    EXPECT_EQ(job.state, JobState::kCancelled);
    const size_t units = unit_count(id);
    EXPECT_GE(units, 3U);
    EXPECT_LT(units, 5000U);
    std::this_thread::sleep_for(200ms);
    EXPECT_EQ(unit_count(id), units) << "units were published after the end";
    EXPECT_TRUE(file(id, this->units(id).at(0).name.probe)->content);
    EXPECT_FALSE(report(id));
}

TEST_F(JobManagerTest, FailuresSayWhyAndNoMoreThanThat) {
    const auto failure_of = [&](const std::function<void()>& thrower) {
        throw_ = thrower;
        start();
        const std::string id = submit(test::net_request(1));
        const JobSnapshot job = wait_until_ended(id);
        EXPECT_EQ(job.state, JobState::kFailed);
        EXPECT_FALSE(cause(id).empty());
        manager_.reset();
        return *job.failure;
    };
    const JobFailure file = failure_of([] { throw IoError("net.vox", "is damaged"); });
    EXPECT_EQ(file.code, "scene");
    EXPECT_EQ(file.detail, "net.vox: is damaged");
    const JobFailure spec =
        failure_of([] { throw SpecError(SpecError::Kind::kUnacceptable, "/probes", "no room"); });
    EXPECT_EQ(spec.code, "scene");
    EXPECT_EQ(spec.issues, (std::vector<SpecIssue>{{"/probes", "no room"}}));
    EXPECT_EQ(failure_of([] { throw std::bad_alloc(); }).code, "memory");
    const JobFailure internal = failure_of([] { throw std::logic_error("secret of line 12"); });
    EXPECT_EQ(internal.code, "internal");
    EXPECT_EQ(internal.detail.find("secret"), std::string::npos);
}

TEST_F(JobManagerTest, AJobThatIsToFailWithItsBudgetDoesAndKeepsWhatThereIs) {
    start();
    Json request = test::net_request(2, 16);
    request["quality"] = {{"targets", {{"psnr_db", 90.0}}}};
    request["budget"] = {{"rays", 2 * 6 * 16 * 16}};
    const std::string best = submit(request);
    request["on_budget_exhausted"] = "fail";
    const std::string id = submit(request);
    EXPECT_EQ(wait_until_ended(best).state, JobState::kSucceeded);
    const JobSnapshot job = wait_until_ended(id);
    EXPECT_EQ(job.state, JobState::kFailed);
    ASSERT_TRUE(job.failure);
    EXPECT_EQ(job.failure->code, "budget");
    EXPECT_NE(report(id)->content, nullptr);
    EXPECT_EQ(unit_count(id), 2U);
}

TEST_F(JobManagerTest, AFileThatCannotBeWrittenFailsTheJob) {
    gated_ = true;
    start();
    const std::string id = submit(test::net_request(1));
    wait_for_waiting(1);
    // Where the folders of the files should be, there are files.
    std::filesystem::remove_all(folder_.path() / "data/files");
    test::write_text(folder_.path() / "data/files", "x");
    gate_.open();
    const JobSnapshot job = wait_until_ended(id);
    EXPECT_EQ(job.state, JobState::kFailed);
    EXPECT_EQ(job.failure->code, "storage");
}

TEST_F(JobManagerTest, ListsNewestFirstInStablePages) {
    gated_ = true;
    start({.max_running = 1, .max_queued = 100});
    std::vector<std::string> ids;
    for (int i = 0; i < 10; ++i) ids.insert(ids.begin(), submit(test::net_request(1)));
    std::vector<std::string> seen;
    std::optional<int64_t> before;
    for (;;) {
        const std::vector<JobSnapshot> page = manager_->list({.before = before, .count = 4});
        if (page.empty()) break;
        for (const JobSnapshot& job : page) seen.push_back(job.id);
        before = page.back().sequence;
        submit(test::net_request(1));  // arrives meanwhile, changes nothing
    }
    EXPECT_EQ(seen, ids);
    gate_.open();
}

TEST_F(JobManagerTest, ForgetsTheOldestFinishedJobs) {
    start({.keep_jobs = 2});
    std::vector<std::string> ids;
    for (int i = 0; i < 4; ++i) {
        ids.push_back(submit(test::net_request(1)));
        wait_until_ended(ids.back());
    }
    // The folder goes just after the job is seen to have ended.
    for (int i = 0; i < 1000 && manager_->find(ids[1]); ++i) std::this_thread::sleep_for(1ms);
    for (const size_t gone : {0U, 1U}) {
        EXPECT_FALSE(manager_->find(ids[gone]));
        EXPECT_FALSE(manager_->cancel(ids[gone]));
    }
    for (const size_t kept : {2U, 3U}) {
        EXPECT_TRUE(manager_->find(ids[kept]));
        EXPECT_TRUE(file(ids[kept], "p0")->content);
    }
    EXPECT_EQ(manager_->list({}).size(), 2U);
    restart({.keep_jobs = 2});
    EXPECT_EQ(manager_->list({}).size(), 2U) << "the store has forgotten them, too";
}

TEST_F(JobManagerTest, ForgetsWhatIsTooOldAndSaysBeforeWhatThatWouldBe) {
    start({.keep_jobs = 1});
    const std::string first = submit(test::net_request(2));
    wait_until_ended(first);
    restart({.keep_time = std::chrono::hours(1)});
    EXPECT_TRUE(manager_->expire(false).jobs.empty());
    restart({.keep_time = 0s});
    // Told or gone already: the manager looks for itself, too.
    const Expired told = manager_->expire(false);
    EXPECT_TRUE(told.jobs.empty() || told.jobs == std::vector<std::string>{first});
    manager_->expire(true);
    EXPECT_FALSE(manager_->find(first));
}

TEST_F(JobManagerTest, ForgetsByBytesButNeverTheNewest) {
    start({.keep_bytes = 12 << 10});
    const std::string first = submit(test::net_request(2));
    wait_until_ended(first);
    EXPECT_TRUE(manager_->find(first));
    const std::string second = submit(test::net_request(8));
    wait_until_ended(second);
    for (int i = 0; i < 1000 && manager_->find(first); ++i) std::this_thread::sleep_for(1ms);
    EXPECT_FALSE(manager_->find(first));
    EXPECT_TRUE(manager_->find(second));
}

TEST_F(JobManagerTest, WhatTheStoreCannotRemoveStaysUntilItCan) {
    start();
    const std::string first = submit(test::net_request(1));
    wait_until_ended(first);
    const std::string second = submit(test::net_request(1));
    wait_until_ended(second);
    gated_ = true;
    const std::string waits = submit(test::net_request(1));
    wait_for_waiting(1);
    restart_changed(
        "CREATE TRIGGER full BEFORE DELETE ON jobs"
        " WHEN EXISTS (SELECT 1 FROM jobs WHERE state < 3) BEGIN SELECT RAISE(ABORT, 'full'); END",
        {.keep_jobs = 1});
    std::this_thread::sleep_for(1500ms);  // rounds in which the first is to be removed
    EXPECT_THROW(manager_->remove(second), IoError);
    EXPECT_TRUE(manager_->find(second));
    wait_until(first, [](const JobSnapshot&) { return true; });
    EXPECT_TRUE(file(second, "p0")->content);
    manager_->cancel(waits);
    wait_until_ended(waits);
    for (int i = 0; i < 12000 && manager_->find(first); ++i) std::this_thread::sleep_for(5ms);
    EXPECT_FALSE(manager_->find(first)) << "there is another round";
}

TEST_F(JobManagerTest, ACancelThatIsNotOnTheDiskIsNone) {
    gated_ = true;
    start();
    const std::string id = submit(test::net_request(1));
    wait_for_waiting(1);
    restart_changed(
        "CREATE TRIGGER full BEFORE UPDATE OF state ON jobs WHEN NEW.state = 2"
        " BEGIN SELECT RAISE(ABORT, 'full'); END");
    wait_for_waiting(2);
    EXPECT_THROW(manager_->cancel(id), IoError);
    EXPECT_EQ(manager_->find(id)->state, JobState::kRunning);
    gate_.open();
    EXPECT_EQ(wait_until_ended(id).state, JobState::kSucceeded);
}

TEST_F(JobManagerTest, CancelledQueuedJobsAreForgottenToo) {
    gated_ = true;
    start({.max_running = 1, .keep_jobs = 5});
    submit(test::net_request(1));
    wait_for_waiting(1);
    for (int i = 0; i < 50; ++i) manager_->cancel(submit(test::net_request(1)));
    manager_->expire(true);
    EXPECT_EQ(manager_->list({}).size(), 6U);
    gate_.open();
}

TEST_F(JobManagerTest, DrainGivesRunningJobsTheirGrace) {
    gated_ = true;
    start({.max_running = 1});
    const std::string running = submit(test::net_request(1));
    const std::string queued = submit(test::net_request(1));
    wait_for_waiting(1);
    const std::jthread opener([&] {
        std::this_thread::sleep_for(50ms);
        gate_.open();
    });
    manager_->drain(60s);
    EXPECT_EQ(manager_->find(running)->state, JobState::kSucceeded);
    EXPECT_EQ(manager_->find(queued)->state, JobState::kQueued) << "for the next start";
    EXPECT_TRUE(manager_->draining());
    try {
        submit(test::net_request(1));
        FAIL() << "a draining service took a job";
    } catch (const ServiceBusy& busy) {
        EXPECT_EQ(busy.code(), "draining");
    }
}

TEST_F(JobManagerTest, DrainStopsWhatRunsLonger) {
    start();
    const std::string id = submit(test::costly_request(5000, 8));
    wait_until(id, [](const JobSnapshot& job) { return job.progress.units_done >= 1; });
    const auto start_time = std::chrono::steady_clock::now();
    manager_->drain(200ms);
    const auto taken = std::chrono::steady_clock::now() - start_time;
    EXPECT_GE(taken, 200ms);
    EXPECT_LT(taken, 1200ms);
    EXPECT_EQ(manager_->find(id)->state, JobState::kQueued);
}

TEST_F(JobManagerTest, HurryEndsTheGrace) {
    gated_ = true;
    start();
    const std::string id = submit(test::net_request(1));
    wait_for_waiting(1);
    const std::jthread hurrier([&] {
        std::this_thread::sleep_for(50ms);
        manager_->hurry();
    });
    manager_->drain(60s);
    EXPECT_EQ(manager_->find(id)->state, JobState::kQueued);
}

TEST_F(JobManagerTest, ProgressHasAnExpectation) {
    start();
    const std::string id = submit(test::costly_request(5000, 8));
    const JobSnapshot job = wait_until(
        id, [](const JobSnapshot& seen) { return seen.progress.seconds_left.has_value(); });
    EXPECT_EQ(job.progress.phase, BakePhase::kRendering);
    EXPECT_EQ(job.progress.units, 5000U);
    EXPECT_GT(*job.progress.seconds_left, 0.0);
    manager_->cancel(id);
    EXPECT_FALSE(wait_until_ended(id).progress.seconds_left);
}

}  // namespace
}  // namespace probebake
