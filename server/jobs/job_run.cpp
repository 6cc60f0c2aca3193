// What a thread of the JobManager does with a job: from the queue to its end.
#include <algorithm>
#include <new>
#include <utility>

#include "bake/report.h"
#include "bake/result_record.h"
#include "io/io_error.h"
#include "io/sha256.h"
#include "jobs/job_manager.h"

namespace probebake {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr size_t kMaxIssues = 100;  // enough to see what is wrong
constexpr uint64_t kBlockBytes = 4096;

/// Ends a job whose scene is not what it was when the job was accepted.
class SceneChanged : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Ends a job whose scene cannot be loaded.
class SceneUnusable : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Takes the rows of a job one by one.
class RowFile {
  public:
    explicit RowFile(const DataFolder& data) : file_(std::make_shared<TemporaryFile>(data)) {}
    void add(const Json& row) {
        buffer_ += write_row_line(row);
        constexpr size_t kBufferBytes = size_t{64} << 10;
        if (buffer_.size() >= kBufferBytes) flush();
    }
    void add_text(std::string text) {
        buffer_ = std::move(text);
        flush();
    }
    /// Durable when it returns.
    JobStore::WrittenFile finish(std::string name) {
        flush();
        file_->sync();
        return {std::move(name), file_->path(), bytes_, sha_.hex()};
    }
    const std::shared_ptr<TemporaryFile>& file() const { return file_; }

  private:
    void flush() {
        file_->write(std::as_bytes(std::span(buffer_)));
        sha_.update(buffer_);
        bytes_ += buffer_.size();
        buffer_.clear();
    }

    std::shared_ptr<TemporaryFile> file_;
    Sha256 sha_;
    uint64_t bytes_ = 0;
    std::string buffer_;
};

std::vector<NewFile> new_files(std::span<const ProductFile> products) {
    std::vector<NewFile> files;
    for (const ProductFile& file : products) files.push_back({file.name, file.bytes, file.sha256});
    return files;
}

UnitName name_of_unit(const JobSpec& job, size_t unit) {
    UnitLabel label = label_of(job, unit);
    return {static_cast<int64_t>(unit), std::move(label.id), std::move(label.state)};
}

}  // namespace

void JobManager::run_jobs(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    JobPtr job;
    std::map<JobPtr, std::set<size_t>>::node_type mend;
    const auto anything = [&] {
        const auto damaged = std::find_if(to_mend_.begin(), to_mend_.end(), [&](const auto& entry) {
            return is_terminal(entry.first->seen.state) && !mending_.contains(entry.first);
        });
        if (damaged != to_mend_.end() && !draining_) {
            mend = to_mend_.extract(damaged);
            return true;
        }
        job = next_job();
        return job != nullptr;
    };
    while (work_.wait(lock, stop, anything)) {
        if (mend) {
            mending_.insert(mend.key());
            lock.unlock();
            run_mend(mend.key(), mend.mapped());
            lock.lock();
            mending_.erase(mend.key());
            mend = {};
        } else {
            queue_.erase(std::find(queue_.begin(), queue_.end(), job));
            running_.insert(job);
            job->running = job->preparing = true;
            job->started = job->progressed = SteadyClock::now();
            lock.unlock();
            run(job);
            lock.lock();
            running_.erase(job);
            job->running = false;
            job.reset();
        }
        changed_.notify_all();
        work_.notify_all();
    }
}

void JobManager::run(const JobPtr& job) {
    const UnixMs now = options_.wall_clock();
    Outcome outcome;
    try {
        store_.start(job->seen.sequence, now);
        {
            const std::lock_guard lock(mutex_);
            if (!job->seen.started) job->seen.started = now;
            if (job->seen.state == JobState::kQueued) enter(*job, JobState::kRunning);
        }
        outcome = bake(*job);
    } catch (const IoError& error) {  // of start(): nothing has been done
        outcome.failure = JobFailure{"storage", error.what(), {}};
        outcome.cause = error.what();
    }
    bool interrupted = false;
    {
        const std::lock_guard lock(mutex_);
        job->preparing = false;
        interrupted = outcome.state == JobState::kCancelled &&
                      job->seen.state == JobState::kRunning && job->stopped;
    }
    if (!interrupted) {
        end(job, outcome);
        return;
    }
    try {
        store_.interrupt(job->seen.sequence);
    } catch (const IoError&) {  // the next start finds it running: the same but for a crash
    }
    const std::lock_guard lock(mutex_);
    enter(*job, JobState::kQueued);
}

void JobManager::end(const JobPtr& job, const Outcome& outcome) {
    JobEnd stored{.state = outcome.state, .ended = options_.wall_clock()};
    if (outcome.failure) stored.failure = dump_json(write_failure(*outcome.failure));
    if (!outcome.warnings.empty()) stored.warnings = dump_json(Json(outcome.warnings));
    uint64_t bytes = 0;
    for (const JobStore::WrittenFile& file : outcome.files) {
        bytes += std::max(kBlockBytes, file.size_bytes);
    }
    {
        const std::lock_guard lock(mutex_);
        stored.seconds = snapshot(*job).progress.seconds;
    }
    const bool ended = store_.end(job->seen.sequence, stored, outcome.files, [&] {
        const std::lock_guard lock(mutex_);
        return draining_;
    });
    const std::lock_guard lock(mutex_);
    if (!ended) return;  // the disk is full and the service ends: the next start goes on
    job->seen.ended = stored.ended;
    job->seen.progress.seconds = stored.seconds;
    job->running = false;
    job->seen.failure = outcome.failure;
    job->seen.warnings = outcome.warnings;
    job->bytes += bytes;
    enter(*job, outcome.state, outcome.cause);
}

JobManager::Outcome JobManager::bake(Job& job) {
    const auto failed = [](std::string code, std::string detail, std::string cause) {
        return Outcome{.state = JobState::kFailed,
                       .failure = JobFailure{std::move(code), std::move(detail), {}},
                       .cause = std::move(cause)};
    };
    try {
        return bake_or_throw(job);
    } catch (const Cancelled&) {
        return {.state = JobState::kCancelled};
    } catch (const SceneChanged& error) {
        return failed("scene_changed", error.what(), error.what());
    } catch (const SceneUnusable& error) {
        return failed("scene", error.what(), error.what());
    } catch (const UnitsFailed& error) {
        Outcome outcome = failed("units", error.what(), error.what());
        outcome.failure->issues = error.issues();
        if (outcome.failure->issues.size() > kMaxIssues) outcome.failure->issues.resize(kMaxIssues);
        return outcome;
    } catch (const SpecError& error) {
        Outcome outcome = failed("scene", "scene and job do not fit", error.what());
        outcome.failure->issues = error.issues();
        return outcome;
    } catch (const IoError& error) {
        return failed("storage", error.what(), error.what());
    } catch (const std::bad_alloc& error) {
        return failed("memory", "the service ran out of memory", error.what());
    } catch (const std::exception& error) {
        return failed("internal", "an internal error, written to the service's log", error.what());
    }
}

JobRequest JobManager::request_of(const Job& job) {
    JobRequest request{.spec = read_job(Json::parse(store_.request_of(job.seen.sequence))),
                       .scene = {}};
    std::optional<SceneFile> scene;
    try {
        scene = scenes_.find(job.seen.scene);
    } catch (const std::exception& error) {
        throw SceneChanged(std::string("the scene cannot be read any more: ") + error.what());
    }
    if (!scene) throw SceneChanged("the scene is gone");
    if (pinned_sha256(*scene, request.spec) != job.scene_sha256) {
        throw SceneChanged(
            "the scene or a picture of a sky was changed after the job had been accepted");
    }
    request.scene = std::move(*scene);
    return request;
}

BakeHistory JobManager::history_of(const Job& job, const JobSpec& spec) {
    StoredUnits units = store_.units_of(job.seen.sequence);
    BakeHistory history;
    for (auto& [unit, record] : units.finished) {
        const auto i = static_cast<size_t>(unit);
        // What has no record that can be read, as atlases, is made again: its files stay as they
        // are.
        if (auto result = read_result_record(record, spec, i)) {
            history.finished.emplace(i, std::move(*result));
        }
    }
    for (const int64_t unit : units.suspects) history.suspects.insert(static_cast<size_t>(unit));
    for (const int64_t unit : units.poison) {
        history.given_up.emplace(static_cast<size_t>(unit),
                                 "the service ended each time that it baked this unit");
    }
    return history;
}

BakeHistory JobManager::history_to_mend(const Job& job, const JobSpec& spec,
                                        const std::set<size_t>& units) {
    std::set<size_t> had;
    for (const auto& [unit, record] : store_.units_of(job.seen.sequence).finished) {
        had.insert(static_cast<size_t>(unit));
    }
    BakeHistory history{.only = units};
    for (size_t unit = 0; unit < unit_count(spec); ++unit) {
        if (!had.contains(unit)) history.given_up.emplace(unit, "the job never had this unit");
    }
    return history;
}

JobManager::Outcome JobManager::bake_or_throw(Job& job) {
    const JobRequest request = request_of(job);
    const JobSpec& spec = request.spec;
    const int64_t sequence = job.seen.sequence;
    std::mutex attempts_mutex;
    std::map<size_t, int64_t> attempts;
    RowFile rows(store_.data());
    const auto publish = [&](size_t unit, std::string record, std::span<const ProductFile> files) {
        int64_t attempt = 0;
        {
            const std::lock_guard lock(attempts_mutex);
            attempt = attempts.extract(unit).mapped();
        }
        store_.publish(sequence, static_cast<int64_t>(unit), attempt, std::move(record),
                       new_files(files));
        const std::lock_guard lock(mutex_);
        job.crashes = 0;
        if (attempt == 0) return;  // published before
        for (const ProductFile& file : files) job.bytes += std::max(kBlockBytes, file.size_bytes);
    };
    const Json report = run_bake(
        {.job = spec,
         .scene =
             [&](const CancelToken& cancel) {
                 try {
                     return scenes_.load(request.scene, cancel);
                 } catch (const IoError& error) {
                     throw SceneUnusable(error.what());
                 }
             },
         .pool = pool_,
         .cancel = job.cancel,
         .sink =
             [&](const ProbeSpec&, const ProbeResult& result) {
                 publish(unit_of(spec, result), write_result_record(result), result.files);
             },
         .grid_sink =
             [&](const GridResult& result) { publish(unit_of(spec, result), {}, result.files); },
         .on_progress =
             [&](const BakeProgress& progress) {
                 const std::lock_guard lock(mutex_);
                 job.seen.progress = progress;
                 job.progressed = SteadyClock::now();
                 const bool preparing = progress.phase < BakePhase::kRendering;
                 if (std::exchange(job.preparing, preparing) != preparing) work_.notify_all();
                 changed(job);
             },
         .row_sink = [&](const Json& row) { rows.add(row); },
         .begin =
             [&](size_t unit) {
                 const int64_t attempt = store_.begin_unit(sequence, name_of_unit(spec, unit));
                 const std::lock_guard lock(attempts_mutex);
                 attempts[unit] = attempt;
             },
         .history = history_of(job, spec),
         .skies =
             [&](const std::filesystem::path& path) { return scenes_.sky(path, job.cancel); }});
    if (options_.on_report) options_.on_report(report);
    RowFile report_file(store_.data());
    report_file.add_text(dump_json(report) + "\n");
    Outcome outcome{.state = JobState::kSucceeded,
                    .warnings = report.at("warnings").get<std::vector<std::string>>()};
    if (const auto failure = budget_failure(spec, report)) {
        outcome.state = JobState::kFailed;
        outcome.cause = *failure;
        outcome.failure = JobFailure{"budget", *failure, {}};
    }
    outcome.files = {rows.finish(kRowFile), report_file.finish(kReportFile)};
    outcome.temporary = {rows.file(), report_file.file()};
    return outcome;
}

void JobManager::run_mend(const JobPtr& job, const std::set<size_t>& units) {
    std::string cause;
    bool possible = true;  // if not now, later
    try {
        const JobRequest request = request_of(*job);
        const JobSpec& spec = request.spec;
        if (spec.budget.seconds) throw NotTheSame("files", "depend on the time that was left");
        const auto mend = [&](size_t unit, std::span<const ProductFile> files) {
            store_.publish(job->seen.sequence, static_cast<int64_t>(unit), 0, {}, new_files(files));
        };
        run_bake(
            {.job = spec,
             .scene =
                 [&](const CancelToken& cancel) { return scenes_.load(request.scene, cancel); },
             .pool = pool_,
             .cancel = job->cancel_mending,
             .sink = [&](const ProbeSpec&,
                         const ProbeResult& result) { mend(unit_of(spec, result), result.files); },
             .grid_sink =
                 [&](const GridResult& result) { mend(unit_of(spec, result), result.files); },
             .history = history_to_mend(*job, spec, units),
             .skies =
                 [&](const std::filesystem::path& path) {
                     return scenes_.sky(path, job->cancel_mending);
                 }});
    } catch (const Cancelled&) {
        return;  // the service ends
    } catch (const SceneChanged& error) {
        cause = error.what();
        possible = false;
    } catch (const NotTheSame& error) {
        cause = error.what();
        possible = false;
    } catch (const std::exception& error) {
        cause = error.what();
    }
    const std::lock_guard lock(mutex_);
    // Who asked again meanwhile asked for what has just been done.
    if (const auto again = to_mend_.find(job); again != to_mend_.end()) {
        for (const size_t unit : units) again->second.erase(unit);
        if (again->second.empty()) to_mend_.erase(again);
    }
    for (const size_t unit : units) {
        if (!possible) not_mendable_.emplace(job->seen.sequence, unit);
    }
    if (options_.on_mend) options_.on_mend(job->seen.id, units.size(), cause);
}

}  // namespace probebake
