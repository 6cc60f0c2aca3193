// JobStore: what the service must not forget, durable before anyone is told of it.
//
// One thread owns the one connection. Writes that arrive while it is busy are committed together
// (group commit), and each returns when its transaction is on the disk; reads come in between and
// see everything that was committed before them. Files are durable before a row names them
// (file_store.h).
//
// A full disk: the ballast is given up, deletions and ends of jobs go through, what would make more
// of it is refused (DiskFull) until there is room again.
//
// Threads: everything may be called from any thread; calls wait for the store's thread.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

#include "store/file_store.h"
#include "store/tables.h"

namespace probebake {

/// Content for a file of the store. The digest is of the bytes.
struct NewFile {
    std::string name;
    std::span<const std::byte> bytes;
    std::string sha256;
};

/// Thrown for a unit that was baked again and gave other files.
class NotTheSame : public IoError {
  public:
    using IoError::IoError;
};

/// A stored file, open, its content checked against its digest.
struct OpenStored {
    int64_t unit = tables::kJobFiles;
    StoredFile file;
    std::shared_ptr<const OpenFile> content;  // null where it is missing or damaged
};

class JobStore {
  public:
    struct Options {
        /// Ends of the process under a unit, or between the units of a job, that make it fail.
        int64_t poison_after = 3;
        /// New jobs are refused while less is free.
        uint64_t min_free_bytes = uint64_t{64} << 20;
    };
    struct Counts {
        uint64_t commits = 0;
        uint64_t writes = 0;  // in them
        double commit_seconds = 0.0;
    };

    /// Throws IoError, in one line, for a directory or database that cannot be used.
    JobStore(const std::filesystem::path& folder, const Options& options);
    /// Everything that was waited for is done by then.
    ~JobStore();
    JobStore(const JobStore&) = delete;
    JobStore& operator=(const JobStore&) = delete;

    /// The jobs as they were found at start.
    std::vector<StoredJob> jobs();

    /// Throws DiskFull.
    tables::Inserted insert(const NewJob& job);
    std::optional<tables::Inserted> find_key(const NewJob& job);
    bool start(int64_t job, UnixMs now);
    std::string request_of(int64_t job);
    StoredUnits units_of(int64_t job);
    int64_t begin_unit(int64_t job, const UnitName& unit);
    /// Stores the files, then names them. Attempt 0 is a unit that was published before: its files
    /// are stored again and must be the same. Throws DiskFull, NotTheSame and IoError.
    void publish(int64_t job, int64_t unit, int64_t attempt, std::string record,
                 const std::vector<NewFile>& files);
    void request_cancel(int64_t job);
    void interrupt(int64_t job);
    /// `written` are complete files of the temporary folder. Waits for room where the disk is full,
    /// until `give_up` says so: the job then goes on at the next start. Whether it ended.
    struct WrittenFile {
        std::string name;
        std::filesystem::path temporary;
        uint64_t size_bytes = 0;
        std::string sha256;
    };
    bool end(int64_t job, JobEnd end, const std::vector<WrittenFile>& written,
             const std::function<bool()>& give_up);
    /// Of a terminal job. Its files go soon after.
    void remove(int64_t job);
    /// The same, by retention: tenant_of_expired knows it.
    void expire(int64_t job);
    std::optional<std::string> tenant_of_expired(const std::string& id);
    void forget_keys(UnixMs created_before);

    std::vector<StoredUnit> published(int64_t job, uint64_t first, size_t count);
    /// No value where no such file was published.
    std::optional<OpenStored> open_unit_file(int64_t job, const std::string& probe,
                                             const std::string& state, const std::string& name);
    std::optional<OpenStored> open_job_file(int64_t job, const std::string& name);
    /// Without a look at its content, for files that carry checks of their own.
    std::optional<OpenStored> open_unchecked(int64_t job, const std::string& name);

    const DataFolder& data() const { return data_; }
    /// Whether new jobs are taken, as far as the disk is concerned.
    bool has_room() const;
    Counts counts() const;
    /// What the process before this one left.
    const tables::Recovered& recovered() const { return recovered_; }
    /// One step of work that can wait: files of jobs that are gone are removed, the ballast is
    /// restored. False where nothing is left to do.
    bool tidy();

  private:
    enum class Kind { kRead, kWrite, kGrow };  // kGrow is refused while the disk is full
    struct Work {
        Kind kind;
        const std::function<void(Database&)>& run;
        std::exception_ptr failure;
        bool done = false;
    };

    std::shared_ptr<const OpenFile> open_checked(const StoredFile& file) const;
    void call(Kind kind, const std::function<void(Database&)>& run);
    void drop(const std::function<std::set<std::string>(Database&)>& remove);
    void serve(const std::stop_token& stop);
    void commit(const std::vector<Work*>& batch);
    void try_commit(const std::vector<Work*>& batch);

    const Options options_;
    const DataFolder data_;
    FileStore files_{data_};
    Database db_;
    tables::Recovered recovered_;

    mutable std::mutex mutex_;
    // Guarded by mutex_:
    std::condition_variable_any work_;
    std::condition_variable done_;
    std::deque<Work*> queue_;
    Counts counts_;
    std::set<std::string> garbage_;
    int swept_ = 0;  // folders of files, since the start

    std::jthread thread_;  // the last member: it uses all of the above
};

}  // namespace probebake
