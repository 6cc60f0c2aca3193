// JobManager: takes checked requests, bakes them, knows what became of them.
//
// At most `max_queued` jobs wait and `max_running` bake at once, each on a thread of its own; their
// work units share the render pool, which starts units of different jobs in turn. Jobs are kept in
// memory: the newest `keep_jobs` finished ones, and of these as many as fit into `keep_bytes` of
// files (the newest always); older ones are forgotten with their files.
//
// Threads: everything may be called from any thread. Files are written before the state that
// promises them is visible.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "engine/render_pool.h"
#include "jobs/artifact_store.h"
#include "jobs/job.h"

namespace probebake {

/// Thrown for a job that cannot be taken now but may be later.
class ServiceBusy : public std::runtime_error {
  public:
    ServiceBusy(std::string code, const std::string& detail)
        : std::runtime_error(detail), code_(std::move(code)) {}
    const std::string& code() const { return code_; }

  private:
    std::string code_;  // "queue-full" or "draining"
};

/// Loads the scene of a file, or takes it from a cache. Throws what SceneCache::get throws.
using SceneSource =
    std::function<std::shared_ptr<const Scene>(const SceneFile&, const CancelToken&)>;

struct JobQuery {
    std::optional<JobState> state;
    std::optional<uint64_t> before;  // sequence number: only older jobs
    size_t count = 100;
};

class JobManager {
  public:
    struct Options {
        int max_running = 4;
        size_t max_queued = 64;
        size_t keep_jobs = 100;
        uint64_t keep_bytes = uint64_t{16} << 30;
        /// Told of every change of state, one call at a time; `cause` is the text of an exception
        /// that the client is not shown. Must not call the manager.
        std::function<void(const JobSnapshot&, const std::string& cause)> on_change;
    };

    JobManager(RenderPool& pool, ArtifactStore& store, SceneSource scenes, Options options);
    /// Cancels every job and waits for those that run.
    ~JobManager();
    JobManager(const JobManager&) = delete;
    JobManager& operator=(const JobManager&) = delete;

    /// Throws ServiceBusy.
    JobSnapshot submit(JobRequest request);
    std::optional<JobSnapshot> find(const std::string& id) const;
    /// Newest first.
    std::vector<JobSnapshot> list(const JobQuery& query) const;
    /// What became of it: CANCELLED where it was queued, CANCELLING where it runs; a terminal job
    /// stays as it is. No value for an unknown id.
    std::optional<JobSnapshot> cancel(const std::string& id);

    /// Takes no more jobs, cancels those that wait, gives running ones `grace` to end, then cancels
    /// them; returns when none runs.
    void drain(std::chrono::milliseconds grace);
    /// Ends the grace of a drain() now.
    void hurry();
    bool draining() const;
    const Options& options() const { return options_; }

  private:
    struct Job {
        JobSnapshot seen;  // guarded by mutex_
        CancelToken cancel;
        std::optional<JobRequest> request;  // until the job has ended
        std::chrono::steady_clock::time_point started;
        std::chrono::steady_clock::time_point progressed;
    };
    struct Outcome {
        JobState state = JobState::kFailed;
        std::optional<JobFailure> failure;
        std::vector<std::string> warnings;
        std::string cause;  // for the log
    };
    using JobPtr = std::shared_ptr<Job>;

    void run_jobs(const std::stop_token& stop);
    Outcome bake(Job& job);
    Outcome bake_or_throw(Job& job);
    // With mutex_ held:
    JobSnapshot snapshot(const Job& job) const;
    void enter(Job& job, JobState state, const std::string& cause = {});
    void cancel_queued();
    /// Releases the lock while it removes files.
    void forget_oldest(std::unique_lock<std::mutex>& lock);

    RenderPool& pool_;
    ArtifactStore& store_;
    const SceneSource scenes_;
    const Options options_;

    mutable std::mutex mutex_;
    // Guarded by mutex_:
    std::condition_variable_any work_;  // the queue grew
    std::condition_variable changed_;   // a job ended, or hurry()
    std::map<std::string, JobPtr> by_id_;
    std::map<uint64_t, JobPtr> by_age_;  // by sequence number
    std::deque<JobPtr> queue_;
    std::deque<JobPtr> finished_;  // oldest first
    uint64_t accepted_ = 0;
    int running_ = 0;
    bool draining_ = false;
    bool hurry_ = false;

    std::vector<std::jthread> runners_;  // the last member: they use all of the above
};

}  // namespace probebake
