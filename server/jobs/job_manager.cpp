#include "jobs/job_manager.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "bake/job_size.h"
#include "io/io_error.h"

namespace probebake {
namespace {

using SteadyClock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// How often is looked for jobs that are too old.
constexpr auto kHouseInterval = 1s;
/// What is left is told anew so often at most, however many ask.
constexpr double kTellLeftSeconds = 0.2;

double seconds_since(SteadyClock::time_point start) {
    return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

UnixMs milliseconds(std::chrono::seconds time) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
}

uint64_t memory_of_machine_bytes() {
    return static_cast<uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
           static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Refuses a job whose cubemaps would not fit into memory, as many as are rendered at once.
void check_memory(const JobSize& size, uint64_t at_once, uint64_t memory_bytes) {
    if (size.unit_bytes <= memory_bytes / at_once) return;
    throw SpecError(SpecError::Kind::kUnacceptable, "/face_size_px",
                    "the largest cubemap takes " + std::to_string(size.unit_bytes) +
                        " bytes of memory, and " + std::to_string(at_once) +
                        " are rendered at once; there are " + std::to_string(memory_bytes));
}

/// Refuses what the disk cannot hold, before anything is promised: `promised_bytes` are those that
/// jobs which wait and run may still write.
void check_disk(const JobSize& size, uint64_t promised_bytes, const DataFolder& data) {
    const uint64_t free_bytes = data.free_bytes();
    if (promised_bytes > free_bytes || size.output_bytes > free_bytes - promised_bytes) {
        throw ServiceBusy("disk-full", "the files may take " + std::to_string(size.output_bytes) +
                                           " bytes; " + std::to_string(free_bytes) + " are free, " +
                                           std::to_string(promised_bytes) +
                                           " of them promised to other jobs");
    }
}

/// Throws SpecError where a file of the scene cannot be read.
std::string readable_sha256(const JobRequest& request) {
    try {
        return pinned_sha256(request.scene, request.spec);
    } catch (const IoError& error) {
        throw SpecError(SpecError::Kind::kUnacceptable, "/scene",
                        std::string("the scene cannot be read: ") + error.what());
    }
}

}  // namespace

JobManager::JobManager(RenderPool& pool, JobStore& store, SceneSource scenes, Options options)
    : pool_(pool), store_(store), scenes_(std::move(scenes)), options_(std::move(options)) {
    load_jobs();
    for (int i = 0; i < options_.max_running; ++i) {
        threads_.emplace_back([this](const std::stop_token& stop) { run_jobs(stop); });
    }
    threads_.emplace_back([this](const std::stop_token& stop) { keep_house(stop); });
}

JobManager::~JobManager() { drain(0ms); }

void JobManager::load_jobs() {
    for (StoredJob& stored : store_.jobs()) {
        const auto job = std::make_shared<Job>();
        JobSnapshot& seen = job->seen;
        seen.id = stored.id;
        seen.tenant = stored.tenant;
        seen.sequence = stored.sequence;
        seen.state = stored.state;
        seen.scene = stored.scene;
        seen.created = stored.created;
        seen.started = stored.started;
        seen.ended = stored.ended;
        seen.progress.units = stored.units;
        seen.progress.units_done = stored.units_done;
        seen.progress.seconds = stored.seconds;
        if (is_terminal(seen.state)) seen.progress.phase = BakePhase::kFinished;
        if (stored.failure) seen.failure = read_failure(Json::parse(*stored.failure));
        if (stored.warnings) seen.warnings = Json::parse(*stored.warnings);
        job->scene_sha256 = stored.scene_sha256;
        job->crashes = stored.crashes;
        job->bytes = stored.bytes;
        job->most_bytes = stored.most_bytes;
        job->priority = stored.priority;
        by_id_.emplace(seen.id, job);
        by_age_.emplace(seen.sequence, job);
        if (!is_terminal(seen.state)) queue_.push_back(job);
        const bool ended_at_start = store_.recovered().ended.contains(seen.sequence);
        if (ended_at_start && options_.on_change) options_.on_change(seen, {});
    }
}

std::optional<JobManager::Submitted> JobManager::replay(const JobRequest& request) {
    if (!request.idempotency_key) return std::nullopt;
    const auto known = store_.find_key({.tenant = request.tenant,
                                        .request_sha256 = request.sha256,
                                        .idempotency_key = request.idempotency_key});
    if (!known) return std::nullopt;
    return replay(*known);
}

JobManager::Submitted JobManager::replay(const tables::Inserted& known) {
    if (known.conflict) throw KeyReused();
    const std::string& id = *known.replay_of;
    {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !submitting_.contains(id); });
    }
    std::optional<JobSnapshot> job = find(id);
    if (!job && store_.tenant_of_expired(id)) throw JobExpired();
    if (!job) throw ServiceBusy("being-removed", "the bake of that key is being removed");
    return {std::move(*job), true};
}

JobManager::Submitted JobManager::submit(const JobRequest& request) {
    // A job that was accepted is told again, however full the queue is by now.
    if (const auto known = replay(request)) return *known;
    const JobSize size = size_of_job(request.spec);
    NewJob stored{.id = new_job_id(),
                  .tenant = request.tenant,
                  .scene = request.scene.name,
                  .scene_sha256 = readable_sha256(request),
                  .request = dump_json(write_job(request.spec)),
                  .request_sha256 = request.sha256,
                  .idempotency_key = request.idempotency_key,
                  .units = unit_count(request.spec),
                  .most_bytes = size.output_bytes,
                  .created = options_.wall_clock()};
    check_memory(size,
                 std::clamp<uint64_t>(stored.units, 1, static_cast<uint64_t>(pool_.threads())),
                 options_.memory_bytes > 0 ? options_.memory_bytes : memory_of_machine_bytes());
    {
        const std::lock_guard lock(mutex_);
        if (draining_) throw ServiceBusy("draining", "the service is shutting down");
        if (queue_.size() + submitting_.size() >= options_.max_queued) {
            throw ServiceBusy("queue-full", std::to_string(options_.max_queued) +
                                                " jobs wait already, the most that may");
        }
        const auto own = [&](const JobPtr& job) { return job->seen.tenant == request.tenant; };
        const auto count =
            std::count_if(queue_.begin(), queue_.end(), own) +
            std::count_if(running_.begin(), running_.end(), own) +
            std::count_if(submitting_.begin(), submitting_.end(),
                          [&](const auto& entry) { return entry.second == request.tenant; });
        if (static_cast<size_t>(count) >= options_.max_per_tenant) {
            throw ServiceBusy("quota", "expected at most " +
                                           std::to_string(options_.max_per_tenant) +
                                           " jobs that wait or run");
        }
        if (!store_.has_room()) throw ServiceBusy("disk-full", "the disk is full");
        check_disk(size, promised(), store_.data());
        submitting_.emplace(stored.id, stored.tenant);
        submitting_bytes_ += size.output_bytes;
    }
    const auto leave = [&] {  // with mutex_ held
        submitting_.erase(stored.id);
        submitting_bytes_ -= size.output_bytes;
        changed_.notify_all();
    };
    tables::Inserted inserted;
    try {
        inserted = store_.insert(stored);
    } catch (...) {
        const std::lock_guard lock(mutex_);
        leave();
        throw;
    }
    {
        const std::lock_guard lock(mutex_);
        leave();
        if (!inserted.replay_of) {
            const auto job = std::make_shared<Job>();
            job->seen.id = stored.id;
            job->seen.tenant = stored.tenant;
            job->seen.sequence = inserted.sequence;
            job->seen.scene = stored.scene;
            job->seen.created = stored.created;
            job->seen.progress.units = stored.units;
            job->scene_sha256 = stored.scene_sha256;
            job->most_bytes = size.output_bytes;
            job->priority = request.spec.priority;
            by_id_.emplace(stored.id, job);
            by_age_.emplace(inserted.sequence, job);
            queue_.push_back(job);
            enter(*job, JobState::kQueued);
            work_.notify_all();
            return {snapshot(*job), false};
        }
    }
    return replay(inserted);
}

uint64_t JobManager::promised_bytes() const {
    const std::lock_guard lock(mutex_);
    return promised();
}

uint64_t JobManager::promised() const {
    uint64_t bytes = submitting_bytes_;
    const auto add = [&](const JobPtr& job) {
        if (job->most_bytes > job->bytes) bytes += job->most_bytes - job->bytes;
    };
    std::for_each(queue_.begin(), queue_.end(), add);
    std::for_each(running_.begin(), running_.end(), add);
    return bytes;
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
        Job& job = *(--at)->second;
        if (query.state && job.seen.state != *query.state) continue;
        if (query.tenant && job.seen.tenant != *query.tenant) continue;
        found.push_back(snapshot(job));
    }
    return found;
}

std::optional<JobSnapshot> JobManager::cancel(const std::string& id) {
    JobPtr job;
    bool waited = false;
    {
        const std::lock_guard lock(mutex_);
        const auto at = by_id_.find(id);
        if (at == by_id_.end()) return std::nullopt;
        job = at->second;
        if (is_terminal(job->seen.state) || job->seen.state == JobState::kCancelling) {
            return snapshot(*job);
        }
        const auto place = std::find(queue_.begin(), queue_.end(), job);
        waited = place != queue_.end();
        if (waited) queue_.erase(place);
    }
    if (waited) {
        end(job, {.state = JobState::kCancelled});
    } else {
        store_.request_cancel(job->seen.sequence);
    }
    const std::lock_guard lock(mutex_);
    if (!waited && !is_terminal(job->seen.state) && job->seen.state != JobState::kCancelling) {
        job->cancel.cancel();
        enter(*job, JobState::kCancelling);
    }
    return snapshot(*job);
}

bool JobManager::remove(const std::string& id) {
    return forget(id, [this](int64_t job) { store_.remove(job); });
}

bool JobManager::forget(const std::string& id, const std::function<void(int64_t)>& on_disk) {
    JobPtr job;
    {
        const std::lock_guard lock(mutex_);
        const auto at = by_id_.find(id);
        if (at == by_id_.end() || !is_terminal(at->second->seen.state)) return false;
        job = at->second;
        by_id_.erase(at);
        by_age_.erase(job->seen.sequence);
        to_mend_.erase(job);
        changed(*job);
    }
    try {
        on_disk(job->seen.sequence);
    } catch (...) {  // it is still there
        const std::lock_guard lock(mutex_);
        by_id_.emplace(id, job);
        by_age_.emplace(job->seen.sequence, job);
        changed(*job);
        throw;
    }
    const std::lock_guard lock(mutex_);
    house_ = true;
    return true;
}

std::optional<JobSnapshot> JobManager::wait_for_change(const std::string& id, uint64_t version,
                                                       std::chrono::milliseconds time) const {
    const auto end = SteadyClock::now() + time;
    std::unique_lock lock(mutex_);
    for (;;) {
        const auto at = by_id_.find(id);
        if (at == by_id_.end()) return std::nullopt;
        const JobPtr job = at->second;
        const bool over = draining_ || is_terminal(job->seen.state);
        if (over || job->seen.version != version || SteadyClock::now() >= end) {
            return snapshot(*job);
        }
        changed_.wait_until(lock, end);
    }
}

JobManager::Mend JobManager::mend(const std::string& id, int64_t unit) {
    const std::lock_guard lock(mutex_);
    const auto at = by_id_.find(id);
    if (at == by_id_.end() || unit < 0) return Mend::kImpossible;
    const auto number = static_cast<size_t>(unit);
    if (not_mendable_.contains({at->second->seen.sequence, number})) return Mend::kImpossible;
    to_mend_[at->second].insert(number);
    work_.notify_all();
    return Mend::kUnderWay;
}

std::vector<JobManager::JobPtr> JobManager::expired() const {
    std::vector<JobPtr> finished;
    for (const auto& [age, job] : by_age_) {
        if (is_terminal(job->seen.state)) finished.push_back(job);
    }
    // Newest first; the first always stays.
    std::sort(finished.begin(), finished.end(), [](const JobPtr& a, const JobPtr& b) {
        return std::pair(a->seen.ended, a->seen.sequence) >
               std::pair(b->seen.ended, b->seen.sequence);
    });
    const UnixMs oldest = options_.wall_clock() - milliseconds(options_.keep_time);
    std::vector<JobPtr> gone;
    uint64_t bytes = 0;
    for (size_t i = 0; i < finished.size(); ++i) {
        bytes += finished[i]->bytes;
        const bool kept =
            i == 0 || (i < options_.keep_jobs && bytes <= options_.keep_bytes && gone.empty());
        const bool old = clock_is_steady() && finished[i]->seen.ended.value_or(0) < oldest;
        if (!kept || old) gone.push_back(finished[i]);
    }
    return gone;
}

UnixMs JobManager::clock_offset() const {
    return options_.wall_clock() - std::chrono::duration_cast<std::chrono::milliseconds>(
                                       SteadyClock::now().time_since_epoch())
                                       .count();
}

bool JobManager::clock_is_steady() const {
    return std::abs(clock_offset() - clock_offset_) < milliseconds(1h);
}

Expired JobManager::expire(bool remove_them) {
    std::vector<JobPtr> old;
    {
        const std::lock_guard lock(mutex_);
        old = this->expired();
    }
    Expired expired;
    for (const JobPtr& job : old) {
        const std::string& id = job->seen.id;
        if (remove_them && !forget(id, [this](int64_t at) { store_.expire(at); })) continue;
        expired.jobs.push_back(id);
        expired.bytes += job->bytes;
    }
    return expired;
}

void JobManager::drain(std::chrono::milliseconds grace) {
    std::unique_lock lock(mutex_);
    draining_ = true;
    changed_.notify_all();
    for (const JobPtr& job : mending_) job->cancel_mending.cancel();
    changed_.wait_for(lock, grace, [&] { return running_.empty() || hurry_; });
    for (const JobPtr& job : running_) {
        job->stopped = true;
        job->cancel.cancel();
    }
    changed_.wait(lock, [&] { return running_.empty() && mending_.empty(); });
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

std::map<JobState, size_t> JobManager::counts() const {
    std::map<JobState, size_t> counts;
    const std::lock_guard lock(mutex_);
    for (const auto& [id, job] : by_id_) ++counts[job->seen.state];
    return counts;
}

void JobManager::keep_house(const std::stop_token& stop) {
    auto keys = SteadyClock::now();
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
        house_ = false;
        lock.unlock();
        try {
            expire(true);
            if (SteadyClock::now() >= keys && clock_is_steady()) {
                store_.forget_keys(options_.wall_clock() - milliseconds(options_.key_time));
                keys = SteadyClock::now() + std::min<std::chrono::seconds>(1min, options_.key_time);
            }
            while (!stop.stop_requested() && store_.tidy()) {
            }
        } catch (const IoError&) {  // a full disk: there is another round
        }
        lock.lock();
        work_.wait_for(lock, stop, kHouseInterval, [&] { return house_; });
    }
}

JobManager::JobPtr JobManager::next_job() const {
    if (draining_) return nullptr;
    bool preparing = false;
    std::map<std::string, size_t> running;
    for (const JobPtr& job : running_) {
        if (job->preparing && job->crashes > 0) return nullptr;
        preparing = preparing || job->preparing;
        ++running[job->seen.tenant];
    }
    JobPtr next;
    for (const JobPtr& job : queue_) {
        if (preparing && job->crashes > 0) continue;
        if (!next || running[job->seen.tenant] < running[next->seen.tenant] ||
            (job->seen.tenant == next->seen.tenant && job->priority > next->priority)) {
            next = job;
        }
    }
    return next;
}

JobSnapshot JobManager::snapshot(Job& job) const {
    if (!job.running) return job.seen;
    BakeProgress& progress = job.seen.progress;
    progress.seconds = seconds_since(job.started);
    if (progress.seconds_left && seconds_since(job.progressed) > kTellLeftSeconds) {
        job.progressed = SteadyClock::now();
        progress.tell_what_is_left(job.progressed);
    }
    return job.seen;
}

void JobManager::enter(Job& job, JobState state, const std::string& cause) {
    job.seen.state = state;
    if (is_terminal(state)) {
        job.seen.progress.seconds_left.reset();
        house_ = true;
        work_.notify_all();
    }
    changed(job);
    if (options_.on_change) options_.on_change(job.seen, cause);
}

void JobManager::changed(Job& job) {
    ++job.seen.version;
    changed_.notify_all();
}

}  // namespace probebake
