// The service's data directory: made at start, locked for as long as the service runs.
//
//   DIR/lock                   held with flock, so that two services never share a directory
//   DIR/probebake.sqlite       jobs, work units, which files they have (tables.h); also -wal
//   DIR/files/ab/abcdef...     files by their SHA-256 (file_store.h)
//   DIR/scenes/NAME/           scenes that clients brought: NAME.json and its files
//   DIR/temporary/             files that are being written; emptied at start
//   DIR/ballast                16 MiB that are given up when the disk is full, so that what must be
//                              written then (deletions, ends of jobs) can be
//
// Entries of directories are on the disk (fsync) before anything relies on them.
#pragma once

#include <cstdint>
#include <filesystem>

#include "store/open_file.h"

namespace probebake {

/// Makes names that were put into a folder durable. Ends the process where that fails.
void sync_folder(const std::filesystem::path& folder);

class DataFolder {
  public:
    static constexpr uint64_t kBallastBytes = uint64_t{16} << 20;

    /// Throws IoError, in one line, where the directory cannot be made, written or locked, or lies
    /// on a file system whose locks and fsync cannot be relied on.
    explicit DataFolder(const std::filesystem::path& folder);

    const std::filesystem::path& path() const { return folder_; }
    std::filesystem::path database() const { return folder_ / "probebake.sqlite"; }
    std::filesystem::path files() const { return folder_ / "files"; }
    std::filesystem::path scenes() const { return folder_ / "scenes"; }
    std::filesystem::path temporary() const { return folder_ / "temporary"; }

    /// Bytes that may still be written.
    uint64_t free_bytes() const;
    /// Whether the database is there and may be written: not where the file system became read-only
    /// or the folder was taken away.
    bool is_writable() const;
    /// Gives the ballast up; false where it was gone already.
    bool drop_ballast() const;
    /// Makes it again, if it is gone and there is twice the room. True when it is there.
    bool restore_ballast() const;

  private:
    std::filesystem::path folder_;
    Descriptor lock_;
};

}  // namespace probebake
