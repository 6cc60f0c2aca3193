#include "jobs/job_manager.h"

#include <algorithm>
#include <new>
#include <utility>

#include "io/io_error.h"

namespace probebake {
namespace {

using SteadyClock = std::chrono::steady_clock;

double seconds_since(SteadyClock::time_point start) {
    return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

}  // namespace

JobManager::JobManager(RenderPool& pool, ArtifactStore& store, SceneSource scenes, Options options)
    : pool_(pool), store_(store), scenes_(std::move(scenes)), options_(std::move(options)) {
    for (int i = 0; i < options_.max_running; ++i) {
        runners_.emplace_back([this](const std::stop_token& stop) { run_jobs(stop); });
    }
}

JobManager::~JobManager() { drain(std::chrono::milliseconds(0)); }

JobSnapshot JobManager::submit(JobRequest request) {
    const auto job = std::make_shared<Job>();
    job->seen.id = new_job_id();
    job->seen.scene = request.scene.name;
    job->seen.created = std::chrono::system_clock::now();
    job->seen.progress.units = request.spec.probes.size() * request.spec.states.size();
    job->request = std::move(request);

    const std::lock_guard lock(mutex_);
    if (draining_) throw ServiceBusy("draining", "the service is shutting down");
    if (queue_.size() >= options_.max_queued) {
        throw ServiceBusy("queue-full",
                          std::to_string(queue_.size()) + " jobs wait already, the most that may");
    }
    store_.add_job(job->seen.id);
    job->seen.sequence = ++accepted_;
    by_id_.emplace(job->seen.id, job);
    by_age_.emplace(job->seen.sequence, job);
    queue_.push_back(job);
    enter(*job, JobState::kQueued);
    work_.notify_one();
    return snapshot(*job);
}

std::optional<JobSnapshot> JobManager::find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const auto at = by_id_.find(id);
    if (at == by_id_.end()) return std::nullopt;
    return snapshot(*at->second);
}

std::vector<JobSnapshot> JobManager::list(const JobQuery& query) const {
    std::vector<JobSnapshot> found;
    const std::lock_guard lock(mutex_);
    auto at = query.before ? by_age_.lower_bound(*query.before) : by_age_.end();
    while (at != by_age_.begin() && found.size() < query.count) {
        const Job& job = *(--at)->second;
        if (!query.state || job.seen.state == *query.state) found.push_back(snapshot(job));
    }
    return found;
}

std::optional<JobSnapshot> JobManager::cancel(const std::string& id) {
    std::unique_lock lock(mutex_);
    const auto at = by_id_.find(id);
    if (at == by_id_.end()) return std::nullopt;
    const JobPtr job = at->second;
    if (job->seen.state == JobState::kQueued) {
        queue_.erase(std::find(queue_.begin(), queue_.end(), job));
        enter(*job, JobState::kCancelled);
    } else if (job->seen.state == JobState::kRunning) {
        job->cancel.cancel();
        enter(*job, JobState::kCancelling);
    }
    JobSnapshot seen = snapshot(*job);
    forget_oldest(lock);
    return seen;
}

void JobManager::drain(std::chrono::milliseconds grace) {
    std::unique_lock lock(mutex_);
    draining_ = true;
    cancel_queued();
    changed_.wait_for(lock, grace, [&] { return running_ == 0 || hurry_; });
    for (const auto& [id, job] : by_id_) {
        if (job->seen.state != JobState::kRunning) continue;
        job->cancel.cancel();
        enter(*job, JobState::kCancelling);
    }
    changed_.wait(lock, [&] { return running_ == 0; });
}

void JobManager::hurry() {
    const std::lock_guard lock(mutex_);
    hurry_ = true;
    changed_.notify_all();
}

bool JobManager::draining() const {
    const std::lock_guard lock(mutex_);
    return draining_;
}

void JobManager::cancel_queued() {
    for (const JobPtr& job : queue_) enter(*job, JobState::kCancelled);
    queue_.clear();
}

void JobManager::run_jobs(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (work_.wait(lock, stop, [&] { return !queue_.empty(); })) {
        const JobPtr job = queue_.front();
        queue_.pop_front();
        ++running_;
        job->started = job->progressed = SteadyClock::now();
        enter(*job, JobState::kRunning);
        lock.unlock();
        Outcome outcome = bake(*job);
        lock.lock();
        job->seen.failure = std::move(outcome.failure);
        job->seen.warnings = std::move(outcome.warnings);
        enter(*job, outcome.state, outcome.cause);
        --running_;
        changed_.notify_all();
        forget_oldest(lock);
    }
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

JobManager::Outcome JobManager::bake_or_throw(Job& job) {
    const std::string& id = job.seen.id;
    ArtifactStore::RowWriter rows(store_, id);
    const Json report = run_bake(
        {.job = job.request->spec,
         .scene = [&](const CancelToken& cancel) { return scenes_(job.request->scene, cancel); },
         .pool = pool_,
         .cancel = job.cancel,
         .sink = [&](const ProbeSpec& probe,
                     const ProbeResult& result) { store_.publish(id, probe.id, result); },
         .grid_sink = [&](const GridResult& result) { store_.publish(id, result); },
         .on_progress =
             [&](const BakeProgress& progress) {
                 const std::lock_guard lock(mutex_);
                 job.seen.progress = progress;
                 job.progressed = SteadyClock::now();
             },
         .row_sink = [&](const Json& row) { rows.add(row); }});
    rows.commit();
    store_.write_report(id, report);
    return {.state = JobState::kSucceeded,
            .warnings = report.at("warnings").get<std::vector<std::string>>()};
}

JobSnapshot JobManager::snapshot(const Job& job) const {
    JobSnapshot seen = job.seen;
    if (!seen.started || seen.ended) return seen;
    seen.progress.seconds = seconds_since(job.started);
    if (seen.progress.seconds_left) {
        const double since = seconds_since(job.progressed);
        const auto later = [since](double seconds) { return std::max(0.0, seconds - since); };
        Interval& interval = seen.progress.seconds_left_interval;
        interval = {later(interval.low), later(interval.high)};
        seen.progress.seconds_left = later(*seen.progress.seconds_left);
    }
    return seen;
}

void JobManager::enter(Job& job, JobState state, const std::string& cause) {
    job.seen.state = state;
    if (state == JobState::kRunning) job.seen.started = std::chrono::system_clock::now();
    if (is_terminal(state)) {
        job.seen.ended = std::chrono::system_clock::now();
        if (job.seen.started) job.seen.progress.seconds = seconds_since(job.started);
        job.seen.progress.seconds_left.reset();
        job.request.reset();
        finished_.push_back(by_id_.at(job.seen.id));
    }
    if (options_.on_change) options_.on_change(job.seen, cause);
}

void JobManager::forget_oldest(std::unique_lock<std::mutex>& lock) {
    uint64_t bytes = 0;
    for (const JobPtr& job : finished_) bytes += store_.bytes_of(job->seen.id);
    std::vector<std::string> forgotten;
    while (finished_.size() > 1 &&
           (finished_.size() > options_.keep_jobs || bytes > options_.keep_bytes)) {
        const JobPtr job = finished_.front();
        finished_.pop_front();
        bytes -= store_.bytes_of(job->seen.id);
        by_id_.erase(job->seen.id);
        by_age_.erase(job->seen.sequence);
        forgotten.push_back(job->seen.id);
    }
    lock.unlock();  // a folder of many files takes a while
    for (const std::string& id : forgotten) store_.remove_job(id);
    lock.lock();
}

}  // namespace probebake
