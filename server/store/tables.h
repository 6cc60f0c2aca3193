// What the database holds, and every statement of SQL about it.
//
//   jobs    one row per accepted job, by its sequence number
//   units   one row per work unit (probe × state) that was begun; those from `jobs.units` on are
//           grids as wholes
//   files   which files a unit (or, as unit −1, the job) has, by their digests
//   expired whose the jobs were that retention removed, of the last million jobs, and their keys
//
// All functions run within a transaction or between two of them, on the thread that owns the
// connection. Those that change a job's state say so only where the state allows it: what was
// decided meanwhile stays.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "store/job_state.h"
#include "store/sqlite.h"

namespace probebake {

/// Milliseconds since 1970, UTC.
using UnixMs = int64_t;
UnixMs unix_ms_now();

struct NewJob {
    std::string id;
    std::string tenant;
    std::string scene;
    std::string scene_sha256;
    std::string request;         // as it was understood, JSON
    std::string request_sha256;  // of what the client sent
    std::optional<std::string> idempotency_key;
    uint64_t units = 0;
    uint64_t most_bytes = 0;  // that its files may take
    UnixMs created = 0;
};

struct StoredJob {
    int64_t sequence = 0;
    std::string id;
    std::string tenant;
    std::string scene;
    std::string scene_sha256;
    JobState state = JobState::kQueued;
    UnixMs created = 0;
    std::optional<UnixMs> started;
    std::optional<UnixMs> ended;
    uint64_t units = 0;
    uint64_t units_done = 0;
    double seconds = 0.0;
    uint64_t bytes = 0;                   // of its files, each as at least one block of 4 KiB
    uint64_t most_bytes = 0;              // that they may take; 0 in rows of version 1
    int priority = 0;                     // of a job that has not ended
    int64_t crashes = 0;                  // ends of the process while the job was between units
    std::optional<std::string> failure;   // JSON
    std::optional<std::string> warnings;  // JSON
};

struct StoredFile {
    std::string name;
    uint64_t size_bytes = 0;
    std::string sha256;
};

/// A work unit: its number within the job, and what it is called.
struct UnitName {
    int64_t unit = 0;
    std::string probe;
    std::string state;
};

/// A finished unit.
struct StoredUnit {
    UnitName name;
    bool is_grid = false;
    std::vector<StoredFile> files;
};

/// A file of a finished unit.
struct UnitFile {
    int64_t unit = 0;
    StoredFile file;
};

/// What an earlier attempt at a job left.
struct StoredUnits {
    std::vector<std::pair<int64_t, std::string>> finished;  // with their records
    std::vector<int64_t> suspects;                          // under way when the process ended
    std::vector<int64_t> poison;                            // too often
};

/// How a job ended.
struct JobEnd {
    JobState state = JobState::kFailed;
    std::optional<std::string> failure;
    std::optional<std::string> warnings;
    double seconds = 0.0;
    UnixMs ended = 0;
    std::vector<StoredFile> files;  // report and rows
};

namespace tables {

inline constexpr int64_t kJobFiles = -1;  // in place of a unit

/// Options of the connection, check of the file, migrations. Throws IoError where the file is
/// damaged or of a newer version.
void open(Database& db);

/// What a crash or a shutdown left: jobs that ran wait again, jobs that were being cancelled are
/// cancelled; units and jobs that were under way count a crash, unless it was a shutdown.
struct Recovered {
    int64_t units = 0;        // that were under way
    int64_t poison = 0;       // of these, those that are given up
    std::set<int64_t> ended;  // jobs that are cancelled or failed by this
};
Recovered recover(Database& db, int64_t poison_after, UnixMs now);
std::vector<StoredJob> jobs(Database& db);

struct Inserted {
    int64_t sequence = 0;
    std::optional<std::string> replay_of;  // the id that this key was used for, expired or not
    bool conflict = false;                 // with another request
};
Inserted insert_job(Database& db, const NewJob& job);
std::optional<Inserted> find_key(Database& db, const NewJob& job);
void forget_keys(Database& db, UnixMs created_before);

/// False where the job is not queued any more. `started` of the first attempt is kept.
bool start_job(Database& db, int64_t job, UnixMs now);
std::string request_of(Database& db, int64_t job);
/// A queued or running job: the next start cancels it, whatever becomes of this process.
void request_cancel(Database& db, int64_t job);
/// Back into the queue: its units that were under way count no crash.
void interrupt_job(Database& db, int64_t job);
/// False where it has ended before.
bool end_job(Database& db, int64_t job, const JobEnd& end);

/// The number of the attempt at this unit, from 1; 0 where it was finished before.
int64_t begin_unit(Database& db, int64_t job, const UnitName& unit);
/// False where the attempt is not the unit's last one or has been published: nothing changes. Grids
/// are none of the units that the job counts.
struct UnitResult {
    int64_t job = 0;
    int64_t unit = 0;
    int64_t attempt = 0;
    std::string record;
    std::vector<StoredFile> files;
};
bool publish_unit(Database& db, const UnitResult& result);
/// Whether the files of a finished unit are exactly these.
bool has_files(Database& db, int64_t job, int64_t unit, const std::vector<StoredFile>& files);
StoredUnits units_of(Database& db, int64_t job);

/// In the order in which they were published, from position `first` on.
std::vector<StoredUnit> published(Database& db, int64_t job, int64_t first, int64_t count);
std::optional<UnitFile> unit_file(Database& db, int64_t job, const std::string& probe,
                                  const std::string& state, const std::string& name);
std::optional<StoredFile> job_file(Database& db, int64_t job, const std::string& name);
bool is_named(Database& db, const std::string& digest);

/// Removes a terminal job; the digests that it named, which others may name, too.
std::set<std::string> delete_job(Database& db, int64_t job);
/// The same, and it is remembered that there was such a job.
std::set<std::string> expire_job(Database& db, int64_t job);
/// Whose the expired job was; no value where there was none.
std::optional<std::string> tenant_of_expired(Database& db, const std::string& id);

}  // namespace tables
}  // namespace probebake
