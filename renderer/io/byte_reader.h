// Bounds-checked little-endian reading; every failure says where in the file it happened.
#pragma once

#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "io/io_error.h"

namespace probebake {

/// Reads a part of a file that starts at `base_offset_bytes` of it. Throws IoError with the offset
/// for every read beyond the end, and with `part_name` ("chunk SIZE") where the part has a name.
/// The machine is little-endian (x86-64).
class ByteReader {
  public:
    ByteReader(std::string file, std::span<const std::byte> bytes, uint64_t base_offset_bytes = 0,
               std::string part_name = {})
        : file_(std::move(file)),
          part_name_(std::move(part_name)),
          bytes_(bytes),
          base_(base_offset_bytes) {}

    template <class T>
    requires std::is_trivially_copyable_v<T> T read(const char* what) {
        T value;
        std::memcpy(&value, take(sizeof(T), what).data(), sizeof(T));
        return value;
    }
    /// The next `count` bytes, without copying.
    std::span<const std::byte> take(uint64_t count, const char* what) {
        if (count > remaining()) {
            fail(std::string(what) + " needs " + std::to_string(count) + " bytes, " +
                 std::to_string(remaining()) + " are left");
        }
        const auto part = bytes_.subspan(at_, count);
        at_ += count;
        return part;
    }
    std::string_view take_text(uint64_t count, const char* what) {
        const auto bytes = take(count, what);
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    /// A reader of the next `count` bytes, which this one passes over.
    ByteReader part(uint64_t count, const char* what, std::string part_name = {}) {
        const uint64_t begin = offset();
        return {file_, take(count, what), begin, std::move(part_name)};
    }
    uint64_t remaining() const { return bytes_.size() - at_; }
    bool done() const { return remaining() == 0; }
    /// Bytes from the start of the file.
    uint64_t offset() const { return base_ + at_; }
    const std::string& file() const { return file_; }

    [[noreturn]] void fail(const std::string& problem) const { fail_at(offset(), problem); }
    /// For what is found wrong after it was read.
    [[noreturn]] void fail_at(uint64_t offset_bytes, const std::string& problem) const {
        throw IoError(file_, offset_bytes,
                      part_name_.empty() ? problem : part_name_ + ": " + problem);
    }

  private:
    std::string file_;
    std::string part_name_;
    std::span<const std::byte> bytes_;
    uint64_t base_;
    size_t at_ = 0;
};

}  // namespace probebake
