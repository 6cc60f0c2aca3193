// JobManager: takes checked requests, bakes them, knows what became of them.
//
// The store decides and remembers; this holds what is needed now: one entry per job, the queue, the
// threads. A job is accepted, started, cancelled or ended when the store says it is on the disk,
// and only then does anybody hear of it. At start every job is as the store has it: those that
// wait or ran are queued again and go on at the unit where they were.
//
// At most `max_queued` jobs wait and `max_running` bake at once, each on a thread of its own; their
// work units share the render pool, which starts units of different jobs in turn. The next job is
// one of the tenant with the fewest that run, the oldest first. A job under whose preparation the
// process ended before prepares alone, so that no other is blamed.
//
// The newest `keep_jobs` finished jobs are kept, of these as many as fit into `keep_bytes` of files
// (the newest whatever its size); none, not even the newest, longer than `keep_time`.
//
// Threads: everything may be called from any thread. mutex_ is never held while the store is waited
// for.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "engine/render_pool.h"
#include "jobs/job.h"
#include "jobs/rows.h"
#include "store/job_store.h"

namespace probebake {

/// Thrown for a job that cannot be taken now but may be later.
class ServiceBusy : public std::runtime_error {
  public:
    ServiceBusy(std::string code, const std::string& detail)
        : std::runtime_error(detail), code_(std::move(code)) {}
    /// "queue-full", "draining", "being-removed", "disk-full" or "quota"
    const std::string& code() const { return code_; }

  private:
    std::string code_;
};

/// Thrown for an idempotency key that came with another request before.
class KeyReused : public std::exception {};

/// Thrown for an idempotency key whose job was removed by retention.
class JobExpired : public std::exception {};

/// What jobs need of the scenes.
struct SceneSource {
    /// No value where there is none of that name. Throws what SceneLibrary::find throws.
    std::function<std::optional<SceneFile>(const std::string&)> find;
    /// Loads the scene, or takes it from a cache. Throws what SceneCache::get throws.
    std::function<std::shared_ptr<const Scene>(const SceneFile&, const CancelToken&)> load;
    /// Decodes a picture of a sky. Throws what SceneCache::sky throws.
    std::function<SkyFile(const std::filesystem::path&, const CancelToken&)> sky =
        [](const std::filesystem::path& picture, const CancelToken&) {
            return read_sky_file(picture);
        };
};

/// Files of a job that has SUCCEEDED, or FAILED by its budget.
inline constexpr const char* kReportFile = "report.json";
inline constexpr const char* kRowFile = "probes.jsonl";

struct JobQuery {
    std::optional<JobState> state;
    std::optional<std::string> tenant;  // none: of all
    std::optional<int64_t> before;      // sequence number: only older jobs
    size_t count = 100;
};

/// Finished jobs that are kept no longer.
struct Expired {
    std::vector<std::string> jobs;
    uint64_t bytes = 0;
};

class JobManager {
  public:
    struct Options {
        int max_running = 4;
        size_t max_queued = 64;
        /// Of one tenant, waiting and running.
        size_t max_per_tenant = 64;
        size_t keep_jobs = 100;
        uint64_t keep_bytes = uint64_t{16} << 30;
        std::chrono::seconds keep_time = std::chrono::hours(24 * 30);
        /// That the cubemaps which are rendered at once may take; 0: what the machine has.
        uint64_t memory_bytes = 0;
        /// How long an idempotency key is known.
        std::chrono::seconds key_time = std::chrono::hours(24);
        /// May jump, also backwards.
        std::function<UnixMs()> wall_clock = unix_ms_now;
        /// Told of every change of state, one call at a time; `cause` is the text of an exception
        /// that the client is not shown. Must not call the manager.
        std::function<void(const JobSnapshot&, const std::string& cause)> on_change;
        /// Shown every report, on the thread of its job. Must not call the manager.
        std::function<void(const Json& report)> on_report;
        /// Told when damaged files were made again, or could not be: `cause` then says why.
        std::function<void(const std::string& id, size_t units, const std::string& cause)> on_mend;
    };
    struct Submitted {
        JobSnapshot job;
        bool replayed = false;
    };
    enum class Mend { kUnderWay, kImpossible };

    JobManager(RenderPool& pool, JobStore& store, SceneSource scenes, Options options);
    /// Stops every job where it is; they go on at the next start.
    ~JobManager();
    JobManager(const JobManager&) = delete;
    JobManager& operator=(const JobManager&) = delete;

    /// Durable when it returns. Throws ServiceBusy, KeyReused, JobExpired, DiskFull, and SpecError
    /// where the scene cannot be read or the cubemaps do not fit into memory.
    Submitted submit(const JobRequest& request);
    /// The job that the request's key stands for; no value where it is new. Needs no scene. Throws
    /// ServiceBusy, KeyReused, JobExpired.
    std::optional<Submitted> replay(const JobRequest& request);
    std::optional<JobSnapshot> find(const std::string& id) const;
    /// Newest first.
    std::vector<JobSnapshot> list(const JobQuery& query) const;
    /// What became of it: CANCELLED where it was queued, CANCELLING where it runs; a terminal job
    /// stays as it is. No value for an unknown id.
    std::optional<JobSnapshot> cancel(const std::string& id);
    /// Forgets a terminal job and its files; false where it is not terminal or not there.
    bool remove(const std::string& id);
    /// Waits until the job's version is another one, at most for `time`.
    std::optional<JobSnapshot> wait_for_change(const std::string& id, uint64_t version,
                                               std::chrono::milliseconds time) const;
    /// A finished unit's file was found damaged: the unit is baked again.
    Mend mend(const std::string& id, int64_t unit);

    /// What retention would remove now; `remove_them`: and does.
    Expired expire(bool remove_them);

    /// Takes no more jobs, gives running ones `grace` to end, then stops them where they are;
    /// returns when none runs. What waits and what was stopped goes on at the next start.
    void drain(std::chrono::milliseconds grace);
    /// Ends the grace of a drain() now.
    void hurry();
    bool draining() const;
    const Options& options() const { return options_; }
    std::map<JobState, size_t> counts() const;
    /// That jobs which wait or run may still write.
    uint64_t promised_bytes() const;

  private:
    struct Job {
        JobSnapshot seen;  // guarded by mutex_
        std::string scene_sha256;
        int64_t crashes = 0;
        uint64_t bytes = 0;       // of its files so far
        uint64_t most_bytes = 0;  // that they may take
        int priority = 0;
        bool running = false;    // on one of the threads
        bool preparing = false;  // loading, lighting, pilot
        CancelToken cancel;
        CancelToken cancel_mending;
        bool stopped = false;  // by the end of the service, not by a client
        std::chrono::steady_clock::time_point started;
        std::chrono::steady_clock::time_point progressed;
    };
    struct Outcome {
        JobState state = JobState::kFailed;
        std::optional<JobFailure> failure;
        std::vector<std::string> warnings;
        std::string cause;  // for the log
        std::vector<JobStore::WrittenFile> files;
        std::vector<std::shared_ptr<TemporaryFile>> temporary;  // those of `files`
    };
    using JobPtr = std::shared_ptr<Job>;

    UnixMs clock_offset() const;
    void load_jobs();
    /// The job that a key was used for.
    Submitted replay(const tables::Inserted& known);
    /// Forgets a terminal job, here and with `on_disk`; where that throws it stays. False where it
    /// is not terminal or not there.
    bool forget(const std::string& id, const std::function<void(int64_t)>& on_disk);
    void run_jobs(const std::stop_token& stop);
    void keep_house(const std::stop_token& stop);
    // job_run.cpp: what a thread does with one job.
    void run(const JobPtr& job);
    Outcome bake(Job& job);
    Outcome bake_or_throw(Job& job);
    /// The request and its scene file, unchanged since the job was accepted. Throws SceneChanged.
    JobRequest request_of(const Job& job);
    BakeHistory history_of(const Job& job, const JobSpec& spec);
    BakeHistory history_to_mend(const Job& job, const JobSpec& spec, const std::set<size_t>& units);
    void run_mend(const JobPtr& job, const std::set<size_t>& units);
    void end(const JobPtr& job, const Outcome& outcome);
    // With mutex_ held:
    bool clock_is_steady() const;
    uint64_t promised() const;
    JobPtr next_job() const;
    JobSnapshot snapshot(Job& job) const;
    void enter(Job& job, JobState state, const std::string& cause = {});
    void changed(Job& job);
    std::vector<JobPtr> expired() const;

    RenderPool& pool_;
    JobStore& store_;
    const SceneSource scenes_;
    const Options options_;

    mutable std::mutex mutex_;
    // Guarded by mutex_:
    std::condition_variable_any work_;             // the queue may have a next job
    mutable std::condition_variable_any changed_;  // a job changed, or hurry()
    std::map<std::string, JobPtr> by_id_;
    std::map<int64_t, JobPtr> by_age_;  // by sequence number
    std::deque<JobPtr> queue_;
    std::set<JobPtr> running_;
    std::map<JobPtr, std::set<size_t>> to_mend_;
    std::set<std::pair<int64_t, size_t>> not_mendable_;
    /// Jobs that are being stored: their tenants by their ids.
    std::map<std::string, std::string> submitting_;
    uint64_t submitting_bytes_ = 0;
    /// Wall clock less steady clock at start: a jump of the wall clock makes nothing old.
    const UnixMs clock_offset_ = clock_offset();
    std::set<JobPtr> mending_;
    bool house_ = true;  // something ended: there may be something to tidy up
    bool draining_ = false;
    bool hurry_ = false;

    std::vector<std::jthread> threads_;  // the last member: they use all of the above
};

}  // namespace probebake
