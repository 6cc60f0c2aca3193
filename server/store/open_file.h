// A file that is open for reading at any place, by several threads at once.
//
// What was opened stays readable when its name is removed meanwhile: a download that began ends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace probebake {

/// Closes a file descriptor.
class Descriptor {
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return fd_; }

  private:
    int fd_;
};

class OpenFile {
  public:
    /// Null where there is no such regular file. Throws IoError where it cannot be opened.
    static std::shared_ptr<const OpenFile> open(const std::filesystem::path& path);

    uint64_t size_bytes() const { return size_bytes_; }
    /// Bytes from `offset` on, as many as there are and fit; the number that was read. Throws
    /// IoError.
    size_t read_at(uint64_t offset, std::span<char> into) const;

  private:
    OpenFile(int fd, uint64_t size_bytes, std::string name);

    Descriptor file_;
    uint64_t size_bytes_;
    std::string name_;
};

}  // namespace probebake
