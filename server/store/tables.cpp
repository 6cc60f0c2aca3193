#include "store/tables.h"

#include <algorithm>
#include <array>
#include <chrono>

namespace probebake {

UnixMs unix_ms_now() {
    return std::chrono::duration_cast<std::chrono::milliseconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
}

namespace tables {
namespace {

constexpr uint64_t kBlockBytes = 4096;

enum class UnitState { kPending, kRunning, kDone, kPoison };

constexpr int kQueued = static_cast<int>(JobState::kQueued);
constexpr int kRunning = static_cast<int>(JobState::kRunning);
constexpr int kCancelling = static_cast<int>(JobState::kCancelling);
constexpr int kFailed = static_cast<int>(JobState::kFailed);
constexpr int kCancelled = static_cast<int>(JobState::kCancelled);
constexpr int kUnitPending = static_cast<int>(UnitState::kPending);
constexpr int kUnitRunning = static_cast<int>(UnitState::kRunning);
constexpr int kUnitDone = static_cast<int>(UnitState::kDone);
constexpr int kUnitPoison = static_cast<int>(UnitState::kPoison);

// One connection, which nobody else may open meanwhile: the index of the write-ahead log then lives
// in memory, and the file-level races of several connections cannot happen. FULL: a commit is on
// the disk when it returns. The page cache is small: what jobs need of the tables is in the job
// manager, and a large one takes in, over days, every row of `expired`.
constexpr const char* kConnection =
    "PRAGMA locking_mode = EXCLUSIVE;"
    "PRAGMA journal_mode = WAL;"
    "PRAGMA synchronous = FULL;"
    "PRAGMA foreign_keys = ON;"
    "PRAGMA trusted_schema = OFF;"
    "PRAGMA journal_size_limit = 67108864;"
    "PRAGMA cache_size = -1024;";

/// migrations[i] makes version i + 1 of version i. A released one is never changed.
constexpr std::array<const char*, 2> kMigrations = {
    "CREATE TABLE jobs ("
    "  sequence INTEGER PRIMARY KEY AUTOINCREMENT,"
    "  id TEXT NOT NULL UNIQUE,"
    "  tenant TEXT NOT NULL,"
    "  state INTEGER NOT NULL,"
    "  scene TEXT NOT NULL,"
    "  scene_sha256 TEXT NOT NULL,"
    "  request TEXT NOT NULL,"
    "  request_sha256 TEXT NOT NULL,"
    "  idempotency_key TEXT,"
    "  created INTEGER NOT NULL,"
    "  started INTEGER,"
    "  ended INTEGER,"
    "  units INTEGER NOT NULL,"
    "  units_done INTEGER NOT NULL DEFAULT 0,"
    "  seconds REAL NOT NULL DEFAULT 0,"
    "  bytes INTEGER NOT NULL DEFAULT 0,"
    "  crashes INTEGER NOT NULL DEFAULT 0,"
    "  failure TEXT,"
    "  warnings TEXT"
    ") STRICT;"
    "CREATE UNIQUE INDEX jobs_by_key ON jobs (tenant, idempotency_key)"
    "  WHERE idempotency_key IS NOT NULL;"
    "CREATE INDEX jobs_by_state ON jobs (state);"
    "CREATE TABLE units ("
    "  job INTEGER NOT NULL REFERENCES jobs ON DELETE CASCADE,"
    "  unit INTEGER NOT NULL,"
    "  probe TEXT NOT NULL,"
    "  lighting TEXT NOT NULL,"
    "  state INTEGER NOT NULL,"
    "  attempt INTEGER NOT NULL,"
    "  crashes INTEGER NOT NULL DEFAULT 0,"
    "  position INTEGER,"
    "  record BLOB,"
    "  PRIMARY KEY (job, unit)"
    ") STRICT;"
    "CREATE UNIQUE INDEX units_by_name ON units (job, probe, lighting);"
    "CREATE UNIQUE INDEX units_by_position ON units (job, position) WHERE position IS NOT NULL;"
    "CREATE TABLE files ("
    "  job INTEGER NOT NULL REFERENCES jobs ON DELETE CASCADE,"
    "  unit INTEGER NOT NULL,"
    "  name TEXT NOT NULL,"
    "  bytes INTEGER NOT NULL,"
    "  sha256 TEXT NOT NULL,"
    "  PRIMARY KEY (job, unit, name)"
    ") STRICT, WITHOUT ROWID;"
    "CREATE INDEX files_by_digest ON files (sha256);",
    "ALTER TABLE jobs ADD COLUMN most_bytes INTEGER NOT NULL DEFAULT 0;"
    "CREATE TABLE expired ("
    "  sequence INTEGER PRIMARY KEY,"
    "  id TEXT NOT NULL UNIQUE,"
    "  tenant TEXT NOT NULL,"
    "  request_sha256 TEXT NOT NULL,"
    "  idempotency_key TEXT,"
    "  created INTEGER NOT NULL"
    ") STRICT;"
    "CREATE INDEX expired_by_key ON expired (tenant, idempotency_key)"
    "  WHERE idempotency_key IS NOT NULL;"};

void check(Database& db) {
    std::string problem;
    db.query("PRAGMA quick_check(1)", [&](const Row& row) { problem = row.text(0); });
    if (problem != "ok") throw IoError("probebake.sqlite", "is damaged: " + problem);
}

void migrate(Database& db) {
    int64_t version = 0;
    db.query("PRAGMA user_version", [&](const Row& row) { version = row.integer(0); });
    if (version < 0 || version > static_cast<int64_t>(kMigrations.size())) {
        throw IoError("probebake.sqlite", "is of version " + std::to_string(version) +
                                              ", expected at most " +
                                              std::to_string(kMigrations.size()) +
                                              ": it was written by a newer service");
    }
    for (auto next = static_cast<size_t>(version); next < kMigrations.size(); ++next) {
        const std::string sql = std::string("BEGIN IMMEDIATE;") + kMigrations[next] +
                                "PRAGMA user_version = " + std::to_string(next + 1) + "; COMMIT;";
        db.execute(sql.c_str());
    }
}

StoredJob read_job(const Row& row) {
    const auto time = [&](int column) {
        return row.null(column) ? std::nullopt : std::optional<UnixMs>(row.integer(column));
    };
    const auto text = [&](int column) {
        return row.null(column) ? std::nullopt : std::optional<std::string>(row.text(column));
    };
    return {.sequence = row.integer(0),
            .id = row.text(1),
            .tenant = row.text(2),
            .scene = row.text(3),
            .scene_sha256 = row.text(4),
            .state = static_cast<JobState>(row.integer(5)),
            .created = row.integer(6),
            .started = time(7),
            .ended = time(8),
            .units = static_cast<uint64_t>(row.integer(9)),
            .units_done = static_cast<uint64_t>(row.integer(10)),
            .seconds = row.real(11),
            .bytes = static_cast<uint64_t>(row.integer(12)),
            .most_bytes = static_cast<uint64_t>(row.integer(13)),
            .priority = static_cast<int>(row.integer(14)),
            .crashes = row.integer(15),
            .failure = text(16),
            .warnings = text(17)};
}

StoredFile read_file(const Row& row) {
    return {row.text(0), static_cast<uint64_t>(row.integer(1)), row.text(2)};
}

std::vector<StoredFile> files_of(Database& db, int64_t job, int64_t unit) {
    std::vector<StoredFile> files;
    db.query(
        "SELECT name, bytes, sha256 FROM files WHERE job = ? AND unit = ? ORDER BY name",
        [&](const Row& row) { files.push_back(read_file(row)); }, job, unit);
    return files;
}

void insert_files(Database& db, int64_t job, int64_t unit, const std::vector<StoredFile>& files) {
    for (const StoredFile& file : files) {
        db.run("INSERT INTO files (job, unit, name, bytes, sha256) VALUES (?, ?, ?, ?, ?)", job,
               unit, file.name, file.size_bytes, file.sha256);
        db.run("UPDATE jobs SET bytes = bytes + ? WHERE sequence = ?",
               std::max(kBlockBytes, file.size_bytes), job);
    }
}

}  // namespace

void open(Database& db) {
    db.execute(kConnection);
    check(db);
    migrate(db);
}

Recovered recover(Database& db, int64_t poison_after, UnixMs now) {
    Recovered recovered;
    // Between units: loading, lighting, the pilot, the report.
    db.run(
        "UPDATE jobs SET crashes = crashes + 1 WHERE state = ? AND NOT EXISTS"
        " (SELECT 1 FROM units WHERE job = sequence AND units.state = ?)",
        kRunning, kUnitRunning);
    recovered.poison = db.run("UPDATE units SET state = ? WHERE state = ? AND crashes + 1 >= ?",
                              kUnitPoison, kUnitRunning, poison_after);
    recovered.units = recovered.poison;
    recovered.units += db.run("UPDATE units SET crashes = crashes + 1, state = ? WHERE state = ?",
                              kUnitPending, kUnitRunning);
    const auto ended = [&](const Row& row) { recovered.ended.insert(row.integer(0)); };
    db.query("UPDATE jobs SET state = ?, ended = ? WHERE state = ? RETURNING sequence", ended,
             kCancelled, now, kCancelling);
    db.query(
        "UPDATE jobs SET state = ?, ended = ?, failure = ? WHERE state = ? AND crashes >= ?"
        " RETURNING sequence",
        ended, kFailed, now,
        R"({"code": "poison", "detail": "the service ended several times while it prepared this job"})",
        kRunning, poison_after);
    db.run("UPDATE jobs SET state = ? WHERE state = ?", kQueued, kRunning);
    return recovered;
}

std::vector<StoredJob> jobs(Database& db) {
    std::vector<StoredJob> found;
    db.query(
        "SELECT sequence, id, tenant, scene, scene_sha256, state, created, started, ended, units,"
        " units_done, seconds, bytes, most_bytes,"
        " CASE WHEN state < ? AND json_valid(request)"
        " THEN coalesce(json_extract(request, '$.priority'), 0) ELSE 0 END,"
        " crashes, failure, warnings FROM jobs ORDER BY sequence",
        [&](const Row& row) { found.push_back(read_job(row)); },
        static_cast<int>(JobState::kSucceeded));
    return found;
}

std::optional<Inserted> find_key(Database& db, const NewJob& job) {
    std::optional<Inserted> found;
    if (!job.idempotency_key) return found;
    const auto take = [&](const Row& row) {
        found = Inserted{row.integer(0), row.text(1), row.text(2) != job.request_sha256};
    };
    db.query(
        "SELECT sequence, id, request_sha256 FROM jobs WHERE tenant = ? AND idempotency_key = ?",
        take, job.tenant, *job.idempotency_key);
    if (found) return found;
    db.query(
        "SELECT sequence, id, request_sha256 FROM expired WHERE tenant = ? AND idempotency_key = ?",
        take, job.tenant, *job.idempotency_key);
    return found;
}

Inserted insert_job(Database& db, const NewJob& job) {
    if (std::optional<Inserted> known = find_key(db, job)) return *known;
    db.run(
        "INSERT INTO jobs (id, tenant, state, scene, scene_sha256, request, request_sha256,"
        " idempotency_key, created, units, most_bytes)"
        " VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
        job.id, job.tenant, kQueued, job.scene, job.scene_sha256, job.request, job.request_sha256,
        job.idempotency_key, job.created, job.units, job.most_bytes);
    return {db.last_row_id(), std::nullopt, false};
}

void forget_keys(Database& db, UnixMs created_before) {
    db.run(
        "UPDATE jobs SET idempotency_key = NULL WHERE idempotency_key IS NOT NULL AND created < ?",
        created_before);
    db.run(
        "UPDATE expired SET idempotency_key = NULL"
        " WHERE idempotency_key IS NOT NULL AND created < ?",
        created_before);
}

bool start_job(Database& db, int64_t job, UnixMs now) {
    return db.run(
               "UPDATE jobs SET state = ?, started = coalesce(started, ?) WHERE sequence = ?"
               " AND state = ?",
               kRunning, now, job, kQueued) > 0;
}

std::string request_of(Database& db, int64_t job) {
    std::string text;
    db.query(
        "SELECT request FROM jobs WHERE sequence = ?", [&](const Row& row) { text = row.text(0); },
        job);
    return text;
}

void request_cancel(Database& db, int64_t job) {
    db.run("UPDATE jobs SET state = ? WHERE sequence = ? AND state IN (?, ?)", kCancelling, job,
           kQueued, kRunning);
}

void interrupt_job(Database& db, int64_t job) {
    db.run("UPDATE units SET state = ? WHERE job = ? AND state = ?", kUnitPending, job,
           kUnitRunning);
    db.run("UPDATE jobs SET state = ? WHERE sequence = ? AND state = ?", kQueued, job, kRunning);
}

bool end_job(Database& db, int64_t job, const JobEnd& end) {
    const int64_t changed = db.run(
        "UPDATE jobs SET state = ?, ended = ?, seconds = ?, failure = ?, warnings = ?"
        " WHERE sequence = ? AND state IN (?, ?, ?)",
        static_cast<int>(end.state), end.ended, end.seconds, end.failure, end.warnings, job,
        kQueued, kRunning, kCancelling);
    if (changed == 0) return false;
    insert_files(db, job, kJobFiles, end.files);
    // What is finished is in the files; the records were for going on.
    db.run("UPDATE units SET record = NULL WHERE job = ? AND record IS NOT NULL", job);
    // What was under way when it was cancelled brings no later process down.
    db.run("UPDATE units SET state = ? WHERE job = ? AND state = ?", kUnitPending, job,
           kUnitRunning);
    return true;
}

int64_t begin_unit(Database& db, int64_t job, const UnitName& unit) {
    int64_t attempt = 0;
    db.query(
        "INSERT INTO units (job, unit, probe, lighting, state, attempt) VALUES (?, ?, ?, ?, ?, 1)"
        " ON CONFLICT (job, unit) DO UPDATE SET state = excluded.state, attempt = attempt + 1"
        " WHERE state <> ? RETURNING attempt",
        [&](const Row& row) { attempt = row.integer(0); }, job, unit.unit, unit.probe, unit.state,
        kUnitRunning, kUnitDone);
    return attempt;
}

bool publish_unit(Database& db, const UnitResult& result) {
    const int64_t changed = db.run(
        "UPDATE units SET state = ?, record = ?,"
        " position = (SELECT coalesce(max(u.position) + 1, 0) FROM units u WHERE u.job = units.job"
        "             AND u.position IS NOT NULL)"
        " WHERE job = ? AND unit = ? AND attempt = ? AND state = ?",
        kUnitDone, Blob{result.record}, result.job, result.unit, result.attempt, kUnitRunning);
    if (changed == 0) return false;
    db.run("UPDATE jobs SET units_done = units_done + (? < units), crashes = 0 WHERE sequence = ?",
           result.unit, result.job);
    insert_files(db, result.job, result.unit, result.files);
    return true;
}

bool has_files(Database& db, int64_t job, int64_t unit, const std::vector<StoredFile>& files) {
    const std::vector<StoredFile> known = files_of(db, job, unit);
    return known.size() == files.size() &&
           std::all_of(files.begin(), files.end(), [&](const StoredFile& file) {
               return std::any_of(known.begin(), known.end(), [&](const StoredFile& k) {
                   return k.name == file.name && k.sha256 == file.sha256;
               });
           });
}

StoredUnits units_of(Database& db, int64_t job) {
    StoredUnits units;
    db.query(
        "SELECT unit, state, crashes, record FROM units WHERE job = ? ORDER BY unit",
        [&](const Row& row) {
            const auto state = static_cast<UnitState>(row.integer(1));
            if (state == UnitState::kDone) {
                units.finished.emplace_back(row.integer(0), row.text(3));
            } else if (state == UnitState::kPoison) {
                units.poison.push_back(row.integer(0));
            } else if (row.integer(2) > 0) {
                units.suspects.push_back(row.integer(0));
            }
        },
        job);
    return units;
}

std::vector<StoredUnit> published(Database& db, int64_t job, int64_t first, int64_t count) {
    std::vector<StoredUnit> units;
    db.query(
        "SELECT unit, probe, lighting, unit >= (SELECT units FROM jobs WHERE sequence = job)"
        " FROM units WHERE job = ? AND position >= ? ORDER BY position LIMIT ?",
        [&](const Row& row) {
            units.push_back({{row.integer(0), row.text(1), row.text(2)}, row.integer(3) != 0, {}});
        },
        job, first, count);
    for (StoredUnit& unit : units) unit.files = files_of(db, job, unit.name.unit);
    return units;
}

std::optional<UnitFile> unit_file(Database& db, int64_t job, const std::string& probe,
                                  const std::string& state, const std::string& name) {
    std::optional<UnitFile> found;
    db.query(
        "SELECT files.name, bytes, sha256, unit FROM units JOIN files USING (job, unit)"
        " WHERE job = ? AND probe = ? AND lighting = ? AND files.name = ?",
        [&](const Row& row) {
            found = UnitFile{row.integer(3), read_file(row)};
        },
        job, probe, state, name);
    return found;
}

std::optional<StoredFile> job_file(Database& db, int64_t job, const std::string& name) {
    std::optional<StoredFile> found;
    db.query(
        "SELECT name, bytes, sha256 FROM files WHERE job = ? AND unit = ? AND name = ?",
        [&](const Row& row) { found = read_file(row); }, job, kJobFiles, name);
    return found;
}

bool is_named(Database& db, const std::string& digest) {
    bool named = false;
    db.query(
        "SELECT 1 FROM files WHERE sha256 = ? LIMIT 1", [&](const Row&) { named = true; }, digest);
    return named;
}

std::set<std::string> delete_job(Database& db, int64_t job) {
    std::set<std::string> digests;
    db.query(
        "SELECT sha256 FROM files WHERE job = ?",
        [&](const Row& row) { digests.insert(row.text(0)); }, job);
    db.run("DELETE FROM jobs WHERE sequence = ?", job);
    return digests;
}

std::set<std::string> expire_job(Database& db, int64_t job) {
    constexpr int64_t kRemembered = 1'000'000;
    db.run(
        "INSERT INTO expired (sequence, id, tenant, request_sha256, idempotency_key, created)"
        " SELECT sequence, id, tenant, request_sha256, idempotency_key, created FROM jobs"
        " WHERE sequence = ?",
        job);
    db.run("DELETE FROM expired WHERE sequence < ? - ?", job, kRemembered);
    return delete_job(db, job);
}

std::optional<std::string> tenant_of_expired(Database& db, const std::string& id) {
    std::optional<std::string> tenant;
    db.query(
        "SELECT tenant FROM expired WHERE id = ?", [&](const Row& row) { tenant = row.text(0); },
        id);
    return tenant;
}

}  // namespace tables
}  // namespace probebake
