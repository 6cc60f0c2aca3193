// Derived data on disk: a header with kind, version and checksum, then sections of plain arrays.
//
//   0   8  magic "PRBBAKE\n"        24  8  bytes of the payload
//   8   8  kind, e.g. "voxtree"     32  8  XXH3-64 of the payload
//   16  8  version                  40     payload: per section its byte count (8) and its bytes
//
// A damaged, truncated, foreign or older file is an IoError that says what is wrong with it; the
// caller makes it anew from its source. Little-endian, written atomically.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "io/byte_reader.h"

namespace probebake {

/// An array as a section.
template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

/// kind has at most 8 characters.
void write_checked_file(const std::filesystem::path& path, std::string_view kind, uint64_t version,
                        std::span<const std::span<const std::byte>> sections);

/// The sections of a file that `write_checked_file` wrote with this kind and version. Throws
/// IoError otherwise.
class CheckedFile {
  public:
    CheckedFile(const std::filesystem::path& path, std::string_view kind, uint64_t version);

    size_t section_count() const { return sections_.size(); }
    /// Copies section i as an array of T. Throws IoError where its size is no multiple of T's.
    template <class T>
    requires std::is_trivially_copyable_v<T> std::vector<T> array(size_t i)
    const {
        const std::span<const std::byte> bytes = section(i);
        if (bytes.size() % sizeof(T) != 0) {
            throw IoError(name_, "section " + std::to_string(i) + " has " +
                                     std::to_string(bytes.size()) + " bytes, no multiple of " +
                                     std::to_string(sizeof(T)));
        }
        std::vector<T> values(bytes.size() / sizeof(T));
        if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
        return values;
    }
    const std::string& name() const { return name_; }

  private:
    std::span<const std::byte> section(size_t i) const;

    std::string name_;
    std::vector<std::byte> bytes_;
    std::vector<std::span<const std::byte>> sections_;
};

}  // namespace probebake
