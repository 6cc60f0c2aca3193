// FileStore: files by the SHA-256 of their content, written once, whole and durable.
//
//   temporary file -> fsync -> rename to files/ab/abcdef... -> fsync of the folder
//
// Then a transaction may name it: a row implies a durable file. The other way round, a file that
// no row names (the service ended in between, its job was deleted) is found by sweep() and
// removed. A Pin keeps a digest from being swept between writing it and naming it.
//
// Threads: everything may be called from any thread.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "store/data_folder.h"

namespace probebake {

class FileStore {
  public:
    explicit FileStore(const DataFolder& data) : data_(data) {}

    /// Digests that are about to be named.
    class Pin {
      public:
        Pin(FileStore& store, std::vector<std::string> digests);
        ~Pin();
        Pin(const Pin&) = delete;
        Pin& operator=(const Pin&) = delete;

      private:
        FileStore& store_;
        const std::vector<std::string> digests_;
    };

    /// Durable when it returns. A file that is there is replaced, which mends a damaged one. Throws
    /// DiskFull and IoError.
    void put(const std::string& digest, std::span<const std::byte> bytes);
    /// The same of a file in the temporary folder, which is moved.
    void adopt(const std::string& digest, const std::filesystem::path& temporary);

    /// Null where it is not there. Not checked against its digest.
    std::shared_ptr<const OpenFile> open(const std::string& digest) const;

    /// Removes the file, unless it is pinned or `named` says so.
    void remove(const std::string& digest, const std::function<bool(const std::string&)>& named);
    /// The same for every file of one of the 256 folders.
    void sweep(int folder, const std::function<bool(const std::string&)>& named);

    const DataFolder& data() const { return data_; }

  private:
    std::filesystem::path path_of(const std::string& digest) const;

    const DataFolder& data_;
    std::mutex mutex_;
    std::multiset<std::string> pinned_;  // guarded by mutex_
};

/// A file in the temporary folder that is filled bit by bit; removed where it was not adopted.
class TemporaryFile {
  public:
    explicit TemporaryFile(const DataFolder& data);
    ~TemporaryFile();
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    /// Throws DiskFull and IoError.
    void write(std::span<const std::byte> bytes);
    /// Makes the content durable. Ends the process where that fails.
    void sync();
    const std::filesystem::path& path() const { return path_; }

  private:
    const std::filesystem::path path_;
    Descriptor file_;
};

/// Whether the content of a file is what its digest says.
bool is_whole(const OpenFile& file, const std::string& digest);

}  // namespace probebake
