// The job manager without HTTP, with scenes that load when the test says so.
#include "jobs/job_manager.h"

#include <gtest/gtest.h>

#include <algorithm>
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
        found_ = file_;
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
        manager_.emplace(pool_, *store_,
                         SceneSource{.find = [this](const std::string&) { return found_; },
                                     .load =
                                         [this](const SceneFile&, const CancelToken& cancel) {
                                             if (gated_) gate_.pass(cancel);
                                             if (throw_) throw_();
                                             return scene_;
                                         }},
                         with_history(options));
    }
    /// As the end of the process and another start.
    void restart(const JobManager::Options& options = {}) {
        manager_.reset();
        store_.reset();
        store_.emplace(folder_.path() / "data", JobStore::Options{});
        start(options);
    }
    std::string submit(const Json& request) {
        return manager_->submit({.spec = read_job(request), .scene = file_}).job.id;
    }
    size_t unit_count(const std::string& id) { return units(id).size(); }
    std::vector<StoredUnit> units(const std::string& id) {
        return store_->published(manager_->find(id)->sequence, 0, 10000);
    }
    std::optional<OpenStored> file(const std::string& id, const std::string& probe) {
        return store_->open_unit_file(manager_->find(id)->sequence, probe, "albedo", "cube.exr");
    }
    std::optional<OpenStored> report(const std::string& id) {
        return store_->open_job_file(manager_->find(id)->sequence, kReportFile);
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
    std::optional<JobStore> store_{std::in_place, folder_.path() / "data", JobStore::Options{}};
    SceneFile file_;                  // of submissions
    std::optional<SceneFile> found_;  // in the library
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
    EXPECT_NE(report(id)->content, nullptr);
    const auto rows = store_->open_unchecked(job.sequence, kRowFile);
    EXPECT_EQ(read_rows(*rows, 0, 10)->rows.size(), 3U);
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

TEST_F(JobManagerTest, AStoppedJobGoesOnAtTheNextStartWhereItWas) {
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

TEST_F(JobManagerTest, JobsWaitThroughARestartInTheirOrder) {
    gated_ = true;
    start({.max_running = 1});
    std::vector<std::string> ids;
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

TEST_F(JobManagerTest, AJobWhoseSceneWasChangedFails) {
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

TEST_F(JobManagerTest, APictureOfASkyIsPinnedToo) {
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

TEST_F(JobManagerTest, AKeyStandsForOneJob) {
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

TEST_F(JobManagerTest, TenantsShareTheThreadsAndHaveAQuota) {
    gated_ = true;
    start({.max_running = 2, .max_per_tenant = 4});
    const auto submit_as = [&](const std::string& tenant) {
        return manager_
            ->submit({.spec = read_job(test::net_request(1)), .scene = file_, .tenant = tenant})
            .job.id;
    };
    std::vector<std::string> greedy;
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

TEST_F(JobManagerTest, ADamagedFileIsBakedAgain) {
    start();
    const std::string id = submit(test::net_request(3));
    wait_until_ended(id);
    const std::string digest = file(id, "p1")->file.sha256;
    const std::filesystem::path path = folder_.path() / "data/files" / digest.substr(0, 2) / digest;
    std::string bytes = test::read_text(path);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
    test::write_text(path, bytes);
    const auto damaged = file(id, "p1");
    EXPECT_EQ(damaged->content, nullptr);
    EXPECT_EQ(manager_->mend(id, damaged->unit), JobManager::Mend::kUnderWay);
    for (int i = 0; i < 60000 && !file(id, "p1")->content; ++i) std::this_thread::sleep_for(5ms);
    EXPECT_TRUE(file(id, "p1")->content);
    EXPECT_EQ(manager_->find(id)->state, JobState::kSucceeded);
    EXPECT_EQ(history(id).size(), 3U) << "a terminal state does not change";
}

TEST_F(JobManagerTest, WhatCannotBeMendedIsSaidToBeSo) {
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

TEST_F(JobManagerTest, AUnitThatFailsLeavesTheOthersRunning) {
    start();
    Json request = test::net_request(3);
    const std::string id = submit(request);
    wait_until_ended(id);
    // The only way to fail a unit from outside: it has brought the process down three times.
    gated_ = true;
    const std::string poisoned = submit(request);
    wait_for_waiting(1);
    const int64_t sequence = manager_->find(poisoned)->sequence;
    for (int crash = 0; crash < 3; ++crash) {
        manager_.reset();
        store_->start(sequence, 1);
        store_->begin_unit(sequence, {1, "p1", "albedo"});
        store_.reset();
        store_.emplace(folder_.path() / "data", JobStore::Options{});
    }
    gated_ = false;
    start();
    const JobSnapshot job = wait_until_ended(poisoned);
    EXPECT_EQ(job.state, JobState::kFailed);
    EXPECT_EQ(job.failure->code, "units");
    ASSERT_EQ(job.failure->issues.size(), 1U);
    EXPECT_EQ(job.failure->issues[0].pointer, "/probes/p1/albedo");
    EXPECT_EQ(unit_count(poisoned), 2U);
    EXPECT_EQ(file(poisoned, "p2")->file.sha256, file(id, "p2")->file.sha256);
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
