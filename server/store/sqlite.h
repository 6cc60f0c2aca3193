// SQLite behind two small classes: a connection and its rows.
//
//   db.run("UPDATE jobs SET state = ? WHERE id = ?", state, id);
//   db.query("SELECT id FROM jobs WHERE state = ?", [&](const Row& row) { row.text(0); }, state);
//
// Statements are prepared once per text. One thread at a time; the texts outlive the connection
// (string literals). A full disk is DiskFull. Whatever may have left the files in doubt (an error
// of the disk, damage) ends the process at once: what is durable is found at the next start, and a
// failed fsync is never tried again (service.md, "Storage").
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "io/io_error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace probebake {

/// There is no room for it.
class DiskFull : public IoError {
  public:
    using IoError::IoError;
};

/// Ends the process with one line on standard error and exit code 74 (EX_IOERR).
[[noreturn]] void fail_stop(const std::string& what);

/// The current row of a query; columns from 0.
class Row {
  public:
    explicit Row(sqlite3_stmt* statement) : statement_(statement) {}
    bool null(int column) const;
    int64_t integer(int column) const;
    double real(int column) const;
    std::string text(int column) const;  // of blobs, too

  private:
    sqlite3_stmt* statement_;
};

/// Bound as a BLOB.
struct Blob {
    std::string_view bytes;
};

class Database {
  public:
    /// Opens or makes the file. Throws IoError.
    explicit Database(const std::filesystem::path& path);
    /// From now on errors of disk and file end the process; before, they are IoErrors.
    void rely_on_it() { relied_on_ = true; }
    ~Database();
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;

    /// Several statements without parameters.
    void execute(const char* sql);
    /// One statement; the number of rows that it changed.
    template <class... Args>
    int64_t run(const char* sql, const Args&... args) {
        return query(
            sql, [](const Row&) {}, args...);
    }
    template <class... Args>
    int64_t query(const char* sql, const std::function<void(const Row&)>& on_row,
                  const Args&... args) {
        sqlite3_stmt* statement = prepared(sql);
        int index = 0;
        (bind(statement, ++index, args), ...);
        return step_all(statement, on_row);
    }
    int64_t last_row_id() const;
    /// Between BEGIN and COMMIT. SQLite ends a transaction of itself where the disk is full.
    bool in_transaction() const;

  private:
    sqlite3_stmt* prepared(const char* sql);
    int64_t step_all(sqlite3_stmt* statement, const std::function<void(const Row&)>& on_row);
    [[noreturn]] void fail(int code) const;

    static void bind(sqlite3_stmt* statement, int index, int64_t value);
    static void bind(sqlite3_stmt* statement, int index, double value);
    static void bind(sqlite3_stmt* statement, int index, std::string_view text);
    static void bind(sqlite3_stmt* statement, int index, const Blob& blob);
    static void bind(sqlite3_stmt* statement, int index, std::nullopt_t);
    static void bind(sqlite3_stmt* s, int i, int value) { bind(s, i, int64_t{value}); }
    static void bind(sqlite3_stmt* s, int i, uint64_t value) {
        bind(s, i, static_cast<int64_t>(value));
    }
    static void bind(sqlite3_stmt* s, int i, const std::string& text) {
        bind(s, i, std::string_view(text));
    }
    static void bind(sqlite3_stmt* s, int i, const char* text) {
        bind(s, i, std::string_view(text));
    }
    template <class T>
    static void bind(sqlite3_stmt* s, int i, const std::optional<T>& value) {
        if (value) {
            bind(s, i, *value);
        } else {
            bind(s, i, std::nullopt);
        }
    }

    const std::string name_;
    sqlite3* connection_ = nullptr;
    bool relied_on_ = false;
    std::map<std::string_view, sqlite3_stmt*> statements_;
};

}  // namespace probebake
