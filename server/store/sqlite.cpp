#include "store/sqlite.h"

#include <sqlite3.h>
#include <unistd.h>

#include <cstdlib>

namespace probebake {

void fail_stop(const std::string& what) {
    const std::string line = "probebake: " + what + "; ended, so that the next start recovers\n";
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), line.size());
    constexpr int kIoError = 74;
    std::_Exit(kIoError);
}

bool Row::null(int column) const {
    return ::sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

int64_t Row::integer(int column) const { return ::sqlite3_column_int64(statement_, column); }

double Row::real(int column) const { return ::sqlite3_column_double(statement_, column); }

std::string Row::text(int column) const {
    const void* bytes = ::sqlite3_column_blob(statement_, column);
    const auto size = static_cast<size_t>(::sqlite3_column_bytes(statement_, column));
    return bytes == nullptr ? std::string() : std::string(static_cast<const char*>(bytes), size);
}

Database::Database(const std::filesystem::path& path) : name_(path.filename().string()) {
    constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX |
                           SQLITE_OPEN_NOFOLLOW | SQLITE_OPEN_EXRESCODE;
    const int code = ::sqlite3_open_v2(path.c_str(), &connection_, kFlags, nullptr);
    // Of a file without permission to write SQLite opens what it may.
    const bool read_only = code == SQLITE_OK && ::sqlite3_db_readonly(connection_, "main") == 1;
    if (code == SQLITE_OK && !read_only) return;
    const std::string problem = read_only ? "it may only be read" : ::sqlite3_errstr(code);
    ::sqlite3_close(connection_);
    throw IoError(name_, "cannot be opened: " + problem);
}

Database::~Database() {
    for (const auto& [sql, statement] : statements_) ::sqlite3_finalize(statement);
    ::sqlite3_close(connection_);
}

void Database::fail(int code) const {
    const std::string problem = ::sqlite3_errmsg(connection_);
    switch (code & 0xff) {
        case SQLITE_FULL:
            throw DiskFull(name_, "the disk is full");
        case SQLITE_IOERR:
        case SQLITE_CORRUPT:
        case SQLITE_NOTADB:
            if (!relied_on_) throw IoError(name_, "cannot be relied on: " + problem);
            fail_stop(name_ + ": " + problem + " (SQLite " + std::to_string(code) + ", errno " +
                      std::to_string(::sqlite3_system_errno(connection_)) + ")");
        default:
            throw IoError(name_, problem + " (SQLite " + std::to_string(code) + ")");
    }
}

void Database::execute(const char* sql) {
    const int code = ::sqlite3_exec(connection_, sql, nullptr, nullptr, nullptr);
    if (code != SQLITE_OK) fail(code);
}

int64_t Database::last_row_id() const { return ::sqlite3_last_insert_rowid(connection_); }

bool Database::in_transaction() const { return ::sqlite3_get_autocommit(connection_) == 0; }

sqlite3_stmt* Database::prepared(const char* sql) {
    sqlite3_stmt*& statement = statements_[sql];
    if (statement == nullptr) {
        const int code = ::sqlite3_prepare_v3(connection_, sql, -1, SQLITE_PREPARE_PERSISTENT,
                                              &statement, nullptr);
        if (code != SQLITE_OK) fail(code);
    }
    return statement;
}

int64_t Database::step_all(sqlite3_stmt* statement, const std::function<void(const Row&)>& on_row) {
    int code = SQLITE_OK;
    try {
        while ((code = ::sqlite3_step(statement)) == SQLITE_ROW) on_row(Row(statement));
    } catch (...) {
        ::sqlite3_reset(statement);
        throw;
    }
    ::sqlite3_reset(statement);
    ::sqlite3_clear_bindings(statement);
    if (code != SQLITE_DONE) fail(code);
    return ::sqlite3_changes64(connection_);
}

void Database::bind(sqlite3_stmt* statement, int index, int64_t value) {
    ::sqlite3_bind_int64(statement, index, value);
}

void Database::bind(sqlite3_stmt* statement, int index, double value) {
    ::sqlite3_bind_double(statement, index, value);
}

// The bytes outlive the step: they are the caller's arguments (null: SQLITE_STATIC).
void Database::bind(sqlite3_stmt* statement, int index, std::string_view text) {
    ::sqlite3_bind_text64(statement, index, text.data() == nullptr ? "" : text.data(), text.size(),
                          nullptr, SQLITE_UTF8);
}

void Database::bind(sqlite3_stmt* statement, int index, const Blob& blob) {
    ::sqlite3_bind_blob64(statement, index, blob.bytes.data(), blob.bytes.size(), nullptr);
}

void Database::bind(sqlite3_stmt* statement, int index, std::nullopt_t) {
    ::sqlite3_bind_null(statement, index);
}

}  // namespace probebake
