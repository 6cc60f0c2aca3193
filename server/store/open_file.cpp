#include "store/open_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "io/io_error.h"

namespace probebake {

Descriptor::~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
}

OpenFile::OpenFile(int fd, uint64_t size_bytes, std::string name)
    : file_(fd), size_bytes_(size_bytes), name_(std::move(name)) {}

std::shared_ptr<const OpenFile> OpenFile::open(const std::filesystem::path& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0 && (errno == ENOENT || errno == ENOTDIR)) return nullptr;
    const std::string name = path.filename().string();
    if (fd < 0) throw IoError(name, std::string("cannot be opened: ") + std::strerror(errno));
    struct stat info {};
    const bool regular = ::fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
    const uint64_t size_bytes = regular ? static_cast<uint64_t>(info.st_size) : 0;
    std::shared_ptr<const OpenFile> file(new OpenFile(fd, size_bytes, name));
    return regular ? file : nullptr;
}

size_t OpenFile::read_at(uint64_t offset, std::span<char> into) const {
    const uint64_t wanted =
        std::min<uint64_t>(into.size(), size_bytes_ - std::min(size_bytes_, offset));
    size_t done = 0;
    while (done < wanted) {
        const ssize_t n = ::pread(file_.get(), into.data() + done, wanted - done,
                                  static_cast<off_t>(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) throw IoError(name_, std::string("cannot be read: ") + std::strerror(errno));
        if (n == 0) throw IoError(name_, offset + done, "the file ended while being read");
        done += static_cast<size_t>(n);
    }
    return done;
}

}  // namespace probebake
