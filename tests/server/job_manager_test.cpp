// The job manager without HTTP, with scenes that load when the test says so.
#include "jobs/job_manager.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <new>

#include "io/io_error.h"
#include "net_jobs.h"

namespace probebake {
namespace {

using test::TempFolder;
using namespace std::chrono_literals;

/// A scene source that makes jobs wait until the gate is open.
class Gate {
  public:
    void open() {
        const std::lock_guard lock(mutex_);
        open_ = true;
    }
    /// As SceneCache::get waits: in short steps, looking at the token.
    void pass(const CancelToken& cancel) {
        ++waiting_;
        for (;;) {
            cancel.throw_if_cancelled();
            {
                const std::lock_guard lock(mutex_);
                if (open_) return;
            }
            std::this_thread::sleep_for(1ms);
        }
    }
    int waiting() const { return waiting_; }

  private:
    std::mutex mutex_;
    bool open_ = false;
    std::atomic<int> waiting_{0};
};

class JobManagerTest : public testing::Test {
  protected:
    JobManagerTest() {
        test::write_scenes(folder_.path() / "scenes");
        file_ = *SceneLibrary(folder_.path() / "scenes").find("net");
        pool_.run([&] { scene_ = std::make_shared<const Scene>(load_scene(file_)); });
    }

    JobManager::Options with_history(JobManager::Options options = {}) {
        options.on_change = [this](const JobSnapshot& job, const std::string& cause) {
            const std::lock_guard lock(mutex_);
            history_[job.id].push_back(job.state);
            if (!cause.empty()) causes_[job.id] = cause;
        };
        return options;
    }
    void start(const JobManager::Options& options = {}) {
        manager_.emplace(
            pool_, store_,
            [this](const SceneFile&, const CancelToken& cancel) {
                if (gated_) gate_.pass(cancel);
                if (throw_) throw_();
                return scene_;
            },
            with_history(options));
    }
    std::string submit(const Json& request) {
        return manager_->submit({read_job(request), file_}).id;
    }
    JobSnapshot wait_until(const std::string& id,
                           const std::function<bool(const JobSnapshot&)>& reached) {
        for (int i = 0; i < 60000; ++i) {  // five minutes, for a busy machine
            const std::optional<JobSnapshot> job = manager_->find(id);
            if (job && reached(*job)) return *job;
            std::this_thread::sleep_for(5ms);
        }
        ADD_FAILURE() << "waited too long";
        return {};
    }
    JobSnapshot wait_until_ended(const std::string& id) {
        return wait_until(id, [](const JobSnapshot& job) { return is_terminal(job.state); });
    }
    void wait_for_waiting(int jobs) {
        for (int i = 0; i < 12000 && gate_.waiting() < jobs; ++i) std::this_thread::sleep_for(1ms);
        ASSERT_GE(gate_.waiting(), jobs);
    }
    std::vector<JobState> history(const std::string& id) {
        const std::lock_guard lock(mutex_);
        return history_[id];
    }
    std::string cause(const std::string& id) {
        const std::lock_guard lock(mutex_);
        return causes_[id];
    }

    TempFolder folder_;
    RenderPool pool_{2};
    ArtifactStore store_{folder_.path() / "data"};
    SceneFile file_;
    std::shared_ptr<const Scene> scene_;
    Gate gate_;
    bool gated_ = false;
    std::function<void()> throw_;
    std::mutex mutex_;
    std::map<std::string, std::vector<JobState>> history_;
    std::map<std::string, std::string> causes_;
    std::optional<JobManager> manager_;
};

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
    EXPECT_NE(store_.open_report(id), nullptr);
    EXPECT_EQ(store_.rows(id, 0, 10)->rows.size(), 3U);
    EXPECT_EQ(store_.unit_count(id), 3U);
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
    EXPECT_LT(std::chrono::steady_clock::now() - start_time, 1s);
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
    EXPECT_LT(std::chrono::steady_clock::now() - start_time, 1s);
    EXPECT_EQ(job.state, JobState::kCancelled);
    const size_t units = store_.unit_count(id);
    EXPECT_GE(units, 3U);
    EXPECT_LT(units, 5000U);
    std::this_thread::sleep_for(200ms);
    EXPECT_EQ(store_.unit_count(id), units) << "units were published after the end";
    const StoredUnit first = store_.units(id, 0, 1).at(0);
    EXPECT_TRUE(store_.open(id, first.probe, "albedo", "cube.exr"));
    EXPECT_EQ(store_.open_report(id), nullptr);
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
    EXPECT_EQ(file.code, "storage");
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

TEST_F(JobManagerTest, AFileThatCannotBeWrittenFailsTheJob) {
    gated_ = true;
    start();
    const std::string id = submit(test::net_request(1));
    wait_for_waiting(1);
    // Where the folder of the probes should be, there is a file.
    test::write_text(folder_.path() / "data/jobs" / id / "probes", "x");
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
    std::optional<uint64_t> before;
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
        EXPECT_TRUE(store_.open(ids[kept], "p0", "albedo", "cube.exr"));
    }
    EXPECT_EQ(manager_->list({}).size(), 2U);
    manager_.reset();
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "data/jobs" / ids[0]));
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "data/jobs" / ids[1]));
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

TEST_F(JobManagerTest, CancelledQueuedJobsAreForgottenToo) {
    gated_ = true;
    start({.max_running = 1, .keep_jobs = 5});
    submit(test::net_request(1));
    wait_for_waiting(1);
    for (int i = 0; i < 200; ++i) manager_->cancel(submit(test::net_request(1)));
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
    EXPECT_EQ(manager_->find(queued)->state, JobState::kCancelled);
    EXPECT_TRUE(manager_->draining());
    try {
        submit(test::net_request(1));
        FAIL() << "a draining service took a job";
    } catch (const ServiceBusy& busy) {
        EXPECT_EQ(busy.code(), "draining");
    }
}

TEST_F(JobManagerTest, DrainCancelsWhatRunsLonger) {
    start();
    const std::string id = submit(test::costly_request(5000, 8));
    wait_until(id, [](const JobSnapshot& job) { return job.progress.units_done >= 1; });
    const auto start_time = std::chrono::steady_clock::now();
    manager_->drain(200ms);
    const auto taken = std::chrono::steady_clock::now() - start_time;
    EXPECT_GE(taken, 200ms);
    EXPECT_LT(taken, 1200ms);
    EXPECT_EQ(manager_->find(id)->state, JobState::kCancelled);
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
    EXPECT_EQ(manager_->find(id)->state, JobState::kCancelled);
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
