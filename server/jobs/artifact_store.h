// ArtifactStore: the files of jobs.
//
//   DIR/jobs/{id}/probes/{probe}/{state}/cube.exr, aux.exr   when the unit is complete
//   DIR/jobs/{id}/probes/{grid}/{state}/ddgi-*.exr           when all of the grid's units are
//   DIR/jobs/{id}/probes.jsonl                               one row per probe and state, at the
//   end DIR/jobs/{id}/report.json                                at the end
//
// An index in memory knows every published file with size and SHA-256; a unit enters it when all of
// its files are written, so that a client never sees half a probe. Names of files come from the
// index, never from a client. (Probes have a folder of their own: "report.json" is a valid id.)
#pragma once

#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "bake/bake_probe.h"
#include "io/json.h"
#include "jobs/data_folder.h"

namespace probebake {

struct StoredFile {
    std::string name;
    uint64_t size_bytes = 0;
    std::string sha256;
};

/// The files of one probe, or of one grid as a whole, in one lighting state.
struct StoredUnit {
    std::string probe;  // or the grid
    std::string state;
    bool is_grid = false;
    std::vector<StoredFile> files;
};

/// A published file, open.
struct OpenArtifact {
    StoredFile file;
    std::shared_ptr<const OpenFile> content;
};

/// Some of a job's rows, as JSON texts, and where the next ones begin.
struct RowPage {
    std::vector<std::string> rows;
    std::optional<uint64_t> next;
};

class ArtifactStore {
  public:
    /// Throws IoError where the directory cannot be used.
    explicit ArtifactStore(const std::filesystem::path& folder);

    void add_job(const std::string& job);
    /// Writes a unit's files, then lets clients see them. Throws IoError.
    void publish(const std::string& job, const std::string& probe, const ProbeResult& result);
    void publish(const std::string& job, const GridResult& result);
    void write_report(const std::string& job, const Json& report);
    /// Forgets a job and removes its files. Downloads under way go on.
    void remove_job(const std::string& job);

    /// Published units in the order in which they were published, from `first` on.
    std::vector<StoredUnit> units(const std::string& job, size_t first, size_t count) const;
    size_t unit_count(const std::string& job) const;
    /// Bytes on the disk, every file counted as at least one block of 4 KiB.
    uint64_t bytes_of(const std::string& job) const;
    /// No value for anything that is not published.
    std::optional<OpenArtifact> open(const std::string& job, const std::string& probe,
                                     const std::string& state, const std::string& name) const;
    std::shared_ptr<const OpenFile> open_report(const std::string& job) const;

    /// Takes rows one by one; they are there for readers once commit() returns.
    class RowWriter {
      public:
        RowWriter(const ArtifactStore& store, const std::string& job);
        ~RowWriter();
        RowWriter(const RowWriter&) = delete;
        RowWriter& operator=(const RowWriter&) = delete;
        void add(const Json& row);
        void commit();

      private:
        [[noreturn]] void fail() const;

        std::filesystem::path path_;
        std::filesystem::path temporary_;
        std::FILE* file_;
    };
    /// Rows from byte `offset` on, at most `count`: 0 or what a page before gave. No value where no
    /// row begins there or the job has no rows. Reads no more than the page.
    std::optional<RowPage> rows(const std::string& job, uint64_t offset, size_t count) const;

  private:
    struct Index {
        std::vector<StoredUnit> units;
        std::unordered_map<std::string, size_t> by_name;  // "probe/state"
        uint64_t bytes = 0;
    };

    std::filesystem::path folder_of(const std::string& job) const { return data_.jobs() / job; }
    void publish(const std::string& job, StoredUnit unit, std::span<const ProductFile> files);

    const DataFolder data_;
    mutable std::mutex mutex_;
    // Guarded by mutex_:
    std::map<std::string, Index> jobs_;
};

}  // namespace probebake
