#include "io/file.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "io/file_beneath.h"

namespace probebake {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& doing) {
    throw IoError(path.filename().string(), doing + ": " + std::strerror(errno));
}

class Descriptor {
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return fd_; }

  private:
    int fd_;
};

std::vector<std::byte> read_whole(const Descriptor& file, const std::filesystem::path& path,
                                  uint64_t max_bytes) {
    if (file.get() < 0) fail(path, "cannot be opened");
    struct stat info {};
    if (::fstat(file.get(), &info) != 0) fail(path, "cannot be examined");
    if (!S_ISREG(info.st_mode)) throw IoError(path.filename().string(), "is not a regular file");
    const auto size = static_cast<uint64_t>(info.st_size);
    if (size > max_bytes) {
        throw IoError(path.filename().string(), "has " + std::to_string(size) +
                                                    " bytes, more than the limit of " +
                                                    std::to_string(max_bytes));
    }
    std::vector<std::byte> bytes(size);
    size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t n = ::read(file.get(), bytes.data() + done, bytes.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(path, "cannot be read");
        if (n == 0)
            throw IoError(path.filename().string(), done, "the file ended while being read");
        done += static_cast<size_t>(n);
    }
    return bytes;
}

/// Opened for reading, or a descriptor below 0 and errno.
Descriptor open_beneath(const std::filesystem::path& folder, const std::filesystem::path& name) {
    const Descriptor root(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    if (root.get() < 0) fail(folder, "cannot be opened");
    open_how how{};
    how.flags = O_RDONLY | O_CLOEXEC;
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS;
    return Descriptor(
        static_cast<int>(::syscall(SYS_openat2, root.get(), name.c_str(), &how, sizeof(how))));
}

}  // namespace

std::vector<std::byte> read_file(const std::filesystem::path& path, uint64_t max_bytes) {
    return read_whole(Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC)), path, max_bytes);
}

std::vector<std::byte> read_file_beneath(const std::filesystem::path& path, uint64_t max_bytes) {
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    return read_whole(open_beneath(folder, path.filename()), path, max_bytes);
}

std::optional<std::vector<std::byte>> find_file_beneath(const std::filesystem::path& folder,
                                                        const std::string& name,
                                                        uint64_t max_bytes) {
    const Descriptor file = open_beneath(folder, name);
    if (file.get() < 0 && (errno == ENOENT || errno == ENOTDIR)) return std::nullopt;
    return read_whole(file, name, max_bytes);
}

void write_file_atomically(const std::filesystem::path& path,
                           std::span<const std::span<const std::byte>> parts) {
    static std::atomic<uint64_t> counter{0};
    const std::filesystem::path temporary =
        path.string() + ".tmp-" + std::to_string(::getpid()) + "-" + std::to_string(counter++);
    const auto give_up = [&](const std::string& doing) {
        const int error = errno;
        ::unlink(temporary.c_str());
        errno = error;
        fail(path, doing);
    };
    {
        const Descriptor file(
            ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
        if (file.get() < 0) fail(path, "cannot be created");
        for (const std::span<const std::byte> part : parts) {
            size_t done = 0;
            while (done < part.size()) {
                const ssize_t n = ::write(file.get(), part.data() + done, part.size() - done);
                if (n < 0 && errno == EINTR) continue;
                if (n < 0) give_up("cannot be written");
                done += static_cast<size_t>(n);
            }
        }
        if (::fsync(file.get()) != 0) give_up("cannot be written to the disk");
    }
    if (::rename(temporary.c_str(), path.c_str()) != 0) give_up("cannot be renamed into place");
}

void write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes) {
    const std::span<const std::byte> parts[] = {bytes};
    write_file_atomically(path, parts);
}

void write_file_atomically(const std::filesystem::path& path, const std::string& text) {
    write_file_atomically(path, std::as_bytes(std::span(text)));
}

}  // namespace probebake
