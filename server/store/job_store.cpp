#include "store/job_store.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <limits>
#include <utility>

namespace probebake {
namespace {

constexpr size_t kTidyStep = 256;  // files
constexpr std::chrono::milliseconds kRoomInterval{500};

}  // namespace

JobStore::JobStore(const std::filesystem::path& folder, const Options& options)
    : options_(options), data_(folder), db_(data_.database()) {
    tables::open(db_);
    db_.execute("BEGIN IMMEDIATE");
    recovered_ = tables::recover(db_, options_.poison_after, unix_ms_now());
    db_.execute("COMMIT");
    sync_folder(data_.path());  // the database and its log
    db_.rely_on_it();
    thread_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
}

JobStore::~JobStore() = default;

void JobStore::call(Kind kind, const std::function<void(Database&)>& run) {
    Work work{kind, run, nullptr, false};
    std::unique_lock lock(mutex_);
    queue_.push_back(&work);
    work_.notify_one();
    done_.wait(lock, [&] { return work.done; });
    if (work.failure) std::rethrow_exception(work.failure);
}

void JobStore::serve(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (work_.wait(lock, stop, [&] { return !queue_.empty(); })) {
        const std::vector<Work*> batch(queue_.begin(), queue_.end());
        queue_.clear();
        lock.unlock();
        commit(batch);
        lock.lock();
        for (Work* work : batch) work->done = true;
        done_.notify_all();
    }
}

void JobStore::commit(const std::vector<Work*>& batch) {
    std::vector<Work*> writes;
    std::copy_if(batch.begin(), batch.end(), std::back_inserter(writes),
                 [](const Work* work) { return work->kind != Kind::kRead; });
    try {
        try_commit(writes);
    } catch (const DiskFull&) {
        // Once more without what would make it fuller, in the room of the ballast.
        data_.drop_ballast();
        std::vector<Work*> essential;
        for (Work* work : writes) {
            work->failure = work->kind == Kind::kGrow ? std::current_exception() : nullptr;
            if (work->kind == Kind::kWrite) essential.push_back(work);
        }
        try {
            try_commit(essential);
        } catch (...) {
            for (Work* work : essential) work->failure = std::current_exception();
        }
    } catch (...) {
        for (Work* work : writes) work->failure = std::current_exception();
    }
    for (Work* work : batch) {
        if (work->kind != Kind::kRead) continue;
        try {
            work->run(db_);
        } catch (...) {
            work->failure = std::current_exception();
        }
    }
}

void JobStore::try_commit(const std::vector<Work*>& batch) {
    if (batch.empty()) return;
    const auto start = std::chrono::steady_clock::now();
    try {
        db_.execute("BEGIN IMMEDIATE");
        for (Work* work : batch) {
            db_.execute("SAVEPOINT work");
            try {
                work->run(db_);
            } catch (const DiskFull&) {
                throw;
            } catch (...) {
                work->failure = std::current_exception();
                db_.execute("ROLLBACK TO work");
            }
            db_.execute("RELEASE work");
        }
        db_.execute("COMMIT");
    } catch (...) {
        if (db_.in_transaction()) db_.execute("ROLLBACK");
        throw;
    }
    const std::lock_guard lock(mutex_);
    ++counts_.commits;
    counts_.writes += batch.size();
    counts_.commit_seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::vector<StoredJob> JobStore::jobs() {
    std::vector<StoredJob> found;
    call(Kind::kRead, [&](Database& db) { found = tables::jobs(db); });
    return found;
}

tables::Inserted JobStore::insert(const NewJob& job) {
    tables::Inserted inserted;
    call(Kind::kGrow, [&](Database& db) { inserted = tables::insert_job(db, job); });
    return inserted;
}

std::optional<tables::Inserted> JobStore::find_key(const NewJob& job) {
    std::optional<tables::Inserted> found;
    call(Kind::kRead, [&](Database& db) { found = tables::find_key(db, job); });
    return found;
}

bool JobStore::start(int64_t job, UnixMs now) {
    bool started = false;
    call(Kind::kWrite, [&](Database& db) { started = tables::start_job(db, job, now); });
    return started;
}

std::string JobStore::request_of(int64_t job) {
    std::string text;
    call(Kind::kRead, [&](Database& db) { text = tables::request_of(db, job); });
    return text;
}

StoredUnits JobStore::units_of(int64_t job) {
    StoredUnits units;
    call(Kind::kRead, [&](Database& db) { units = tables::units_of(db, job); });
    return units;
}

int64_t JobStore::begin_unit(int64_t job, const UnitName& unit) {
    int64_t attempt = 0;
    call(Kind::kGrow, [&](Database& db) { attempt = tables::begin_unit(db, job, unit); });
    return attempt;
}

void JobStore::publish(int64_t job, int64_t unit, int64_t attempt, std::string record,
                       const std::vector<NewFile>& files) {
    tables::UnitResult result{job, unit, attempt, std::move(record), {}};
    std::vector<std::string> digests;
    for (const NewFile& file : files) {
        result.files.push_back({file.name, file.bytes.size(), file.sha256});
        digests.push_back(file.sha256);
    }
    const FileStore::Pin pin(files_, digests);
    for (const NewFile& file : files) files_.put(file.sha256, file.bytes);
    bool published = false;
    if (attempt == 0) {
        call(Kind::kRead,
             [&](Database& db) { published = tables::has_files(db, job, unit, result.files); });
        if (!published) throw NotTheSame("files", "a unit that was baked again is not the same");
        return;
    }
    call(Kind::kGrow, [&](Database& db) { published = tables::publish_unit(db, result); });
    if (!published) throw IoError("files", "another attempt at this unit came first");
}

void JobStore::request_cancel(int64_t job) {
    call(Kind::kWrite, [&](Database& db) { tables::request_cancel(db, job); });
}

void JobStore::interrupt(int64_t job) {
    call(Kind::kWrite, [&](Database& db) { tables::interrupt_job(db, job); });
}

bool JobStore::end(int64_t job, JobEnd end, const std::vector<WrittenFile>& written,
                   const std::function<bool()>& give_up) {
    std::vector<std::string> digests;
    digests.reserve(written.size());
    for (const WrittenFile& file : written) digests.push_back(file.sha256);
    const FileStore::Pin pin(files_, digests);
    for (const WrittenFile& file : written) {
        files_.adopt(file.sha256, file.temporary);
        end.files.push_back({file.name, file.size_bytes, file.sha256});
    }
    for (;;) {
        try {
            bool ended = false;
            call(Kind::kWrite, [&](Database& db) { ended = tables::end_job(db, job, end); });
            return ended;
        } catch (const DiskFull&) {
            if (give_up()) return false;
            std::this_thread::sleep_for(kRoomInterval);
        }
    }
}

void JobStore::drop(const std::function<std::set<std::string>(Database&)>& remove) {
    std::set<std::string> digests;
    call(Kind::kWrite, [&](Database& db) { digests = remove(db); });
    const std::lock_guard lock(mutex_);
    garbage_.merge(digests);
}

void JobStore::remove(int64_t job) {
    drop([&](Database& db) { return tables::delete_job(db, job); });
}

void JobStore::expire(int64_t job) {
    drop([&](Database& db) { return tables::expire_job(db, job); });
}

std::optional<std::string> JobStore::tenant_of_expired(const std::string& id) {
    std::optional<std::string> tenant;
    call(Kind::kRead, [&](Database& db) { tenant = tables::tenant_of_expired(db, id); });
    return tenant;
}

void JobStore::forget_keys(UnixMs created_before) {
    call(Kind::kWrite, [&](Database& db) { tables::forget_keys(db, created_before); });
}

std::vector<StoredUnit> JobStore::published(int64_t job, uint64_t first, size_t count) {
    std::vector<StoredUnit> units;
    if (first > static_cast<uint64_t>(std::numeric_limits<int64_t>::max())) return units;
    call(Kind::kRead, [&](Database& db) {
        units =
            tables::published(db, job, static_cast<int64_t>(first), static_cast<int64_t>(count));
    });
    return units;
}

std::shared_ptr<const OpenFile> JobStore::open_checked(const StoredFile& file) const {
    std::shared_ptr<const OpenFile> content = files_.open(file.sha256);
    const bool whole =
        content && content->size_bytes() == file.size_bytes && is_whole(*content, file.sha256);
    return whole ? content : nullptr;
}

std::optional<OpenStored> JobStore::open_unit_file(int64_t job, const std::string& probe,
                                                   const std::string& state,
                                                   const std::string& name) {
    std::optional<UnitFile> found;
    call(Kind::kRead,
         [&](Database& db) { found = tables::unit_file(db, job, probe, state, name); });
    if (!found) return std::nullopt;
    return OpenStored{found->unit, found->file, open_checked(found->file)};
}

std::optional<OpenStored> JobStore::open_job_file(int64_t job, const std::string& name) {
    std::optional<StoredFile> found;
    call(Kind::kRead, [&](Database& db) { found = tables::job_file(db, job, name); });
    if (!found) return std::nullopt;
    return OpenStored{tables::kJobFiles, *found, open_checked(*found)};
}

std::optional<OpenStored> JobStore::open_unchecked(int64_t job, const std::string& name) {
    std::optional<StoredFile> found;
    call(Kind::kRead, [&](Database& db) { found = tables::job_file(db, job, name); });
    if (!found) return std::nullopt;
    return OpenStored{tables::kJobFiles, *found, files_.open(found->sha256)};
}

bool JobStore::has_room() const { return data_.free_bytes() >= options_.min_free_bytes; }

JobStore::Counts JobStore::counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
}

bool JobStore::tidy() {
    const auto named = [](Database& db) {
        return [&db](const std::string& digest) { return tables::is_named(db, digest); };
    };
    std::vector<std::string> step;
    std::optional<int> folder;
    {
        const std::lock_guard lock(mutex_);
        while (!garbage_.empty() && step.size() < kTidyStep) {
            step.push_back(std::move(garbage_.extract(garbage_.begin()).value()));
        }
        if (step.empty() && swept_ < 256) folder = swept_++;
    }
    if (!step.empty()) {
        call(Kind::kRead, [&](Database& db) {
            for (const std::string& digest : step) files_.remove(digest, named(db));
        });
        return true;
    }
    if (folder) {
        call(Kind::kRead, [&](Database& db) { files_.sweep(*folder, named(db)); });
        return true;
    }
    data_.restore_ballast();
    return false;
}

}  // namespace probebake
