// A job manager without HTTP, in a folder of its own, with scenes that load when the test says so;
// it can be ended and started again.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "jobs/job_manager.h"
#include "net_jobs.h"

namespace probebake::test {

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

class JobFixture : public testing::Test {
  protected:
    JobFixture() {
        write_scenes(folder_.path() / "scenes");
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
        options.on_mend = [this](const std::string&, size_t, const std::string& cause) {
            const std::lock_guard lock(mutex_);
            mends_.push_back(cause);
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
    /// The same, with a database that was changed in between.
    void restart_changed(const char* sql, const JobManager::Options& options = {}) {
        manager_.reset();
        store_.reset();
        Database(folder_.path() / "data/probebake.sqlite").execute(sql);
        store_.emplace(folder_.path() / "data", JobStore::Options{});
        start(options);
    }
    /// A job that has ended without this unit: it brought the process down three times, the only
    /// way to fail a unit from outside.
    std::string bake_without(const Json& request, const UnitName& unit) {
        gated_ = true;
        std::string id = submit(request);
        wait_for_waiting(1);
        const int64_t sequence = manager_->find(id)->sequence;
        for (int crash = 0; crash < 3; ++crash) {
            manager_.reset();
            store_->start(sequence, 1);
            store_->begin_unit(sequence, unit);
            store_.reset();
            store_.emplace(folder_.path() / "data", JobStore::Options{});
        }
        EXPECT_EQ(store_->recovered().units, 1);
        EXPECT_EQ(store_->recovered().poison, 1);
        gated_ = false;
        start();
        wait_until_ended(id);
        return id;
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
    /// What was said of every mend that ended: nothing, or why it failed.
    std::vector<std::string> mends() {
        const std::lock_guard lock(mutex_);
        return mends_;
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
    std::vector<std::string> mends_;
    std::optional<JobManager> manager_;
};

}  // namespace probebake::test
