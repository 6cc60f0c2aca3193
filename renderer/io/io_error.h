// What is thrown for a file that cannot be read, written or believed.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

namespace probebake {

/// what() reads "FILE: offset N: what was wrong, what was expected". Names of files are those the
/// caller gave; the service never shows it a path that a client could not know.
class IoError : public std::runtime_error {
  public:
    IoError(const std::string& file, const std::string& problem)
        : std::runtime_error(file + ": " + problem), file_(file) {}
    IoError(const std::string& file, uint64_t offset_bytes, const std::string& problem)
        : std::runtime_error(file + ": offset " + std::to_string(offset_bytes) + ": " + problem),
          file_(file),
          offset_bytes_(offset_bytes) {}

    const std::string& file() const { return file_; }
    /// Bytes from the start of the file, where the problem has a place.
    std::optional<uint64_t> offset_bytes() const { return offset_bytes_; }

  private:
    std::string file_;
    std::optional<uint64_t> offset_bytes_;
};

}  // namespace probebake
