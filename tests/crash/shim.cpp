// A library that is loaded before libc (LD_PRELOAD) and stands between a program and the disk: it
// writes down what a program does to the files below a folder, and fails or kills it on the way.
//
//   SHIM_ROOT         the folder (absolute); everything else passes untouched
//   SHIM_LOG          file that takes every change of a file, for the power-cut model (disk_log.h)
//   SHIM_ACK          file whose writes are in the log, too: what the program promised to anybody
//   SHIM_FAIL         "eio:N": fail the N-th write, sync or rename; "fsync:N": the N-th sync;
//                     "emfile:N": the N-th open; "enospc:N": the N-th of all of these and of
//                     folders made, and all that follow and need room, but for 16 MiB once a file
//                     "ballast" is unlinked
//   SHIM_KILL         SIGKILL at a rename to a path that holds this text
//   SHIM_FS_TYPE      what statfs says of the type of a file system below the folder (hexadecimal)
//   SHIM_CLOCK        file with a number of seconds that is added to the wall clock
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <mutex>
#include <string>

#include "disk_log.h"

namespace {

using probebake::test::DiskOp;
using probebake::test::write_disk_op;

template <class F>
F* real(const char* name) {
    return reinterpret_cast<F*>(::dlsym(RTLD_NEXT, name));
}

std::string variable(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
}

struct Shim {
    const std::string root = variable("SHIM_ROOT");
    const std::string ack = variable("SHIM_ACK");
    const std::string kill = variable("SHIM_KILL");
    const std::string log_path = variable("SHIM_LOG");
    std::string fail = variable("SHIM_FAIL");
    long fail_at = -1;
    long count = 0;
    long long room = 0;  // once the disk is full
    int log = -1;
    std::recursive_mutex mutex;

    Shim() {
        const size_t colon = fail.find(':');
        if (colon != std::string::npos) {
            fail_at = std::atol(fail.c_str() + colon + 1);
            fail.resize(colon);
        }
        if (!log_path.empty()) {
            log = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, log_path.c_str(),
                                             O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
        }
    }
    bool below_root(const std::string& path) const {
        return !root.empty() && path.compare(0, root.size(), root) == 0;
    }
    bool watched(const std::string& path) const {
        return below_root(path) || (!ack.empty() && path == ack);
    }
    void record(DiskOp::Kind kind, const std::string& path, const std::string& to, uint64_t offset,
                const void* data, uint64_t size) {
        if (log < 0 || !watched(path)) return;
        const std::string bytes = write_disk_op(
            {path == ack ? DiskOp::kAck : kind, path, to, offset,
             data == nullptr ? std::string() : std::string(static_cast<const char*>(data), size)});
        ::syscall(SYS_write, log, bytes.data(), bytes.size());
    }
    /// 0, or the error with which this operation is to fail.
    int failure(const char* kind, const std::string& path, long long grows) {
        if (fail_at < 0 || !below_root(path)) return 0;
        const bool opens = std::strcmp(kind, "open") == 0;
        const bool makes_folder = std::strcmp(kind, "mkdir") == 0;
        if (fail == "emfile" && !opens) return 0;
        if (fail == "eio" && (opens || makes_folder)) return 0;
        if (fail == "fsync" && std::strcmp(kind, "sync") != 0) return 0;
        const long now = ++count;
        if (fail == "enospc") {
            if (now < fail_at || grows == 0) return 0;
            if (room >= grows) {
                room -= grows;
                return 0;
            }
            return ENOSPC;
        }
        if (now != fail_at) return 0;
        return fail == "emfile" ? EMFILE : EIO;
    }
};

Shim& shim() {
    static auto* instance = new Shim;  // outlives every static object
    return *instance;
}

std::string path_of(int fd) {
    const std::string link = "/proc/self/fd/" + std::to_string(fd);
    std::array<char, PATH_MAX> path{};
    const ssize_t n = ::readlink(link.c_str(), path.data(), path.size() - 1);
    return n > 0 ? std::string(path.data(), static_cast<size_t>(n)) : "";
}

ssize_t write_to(int fd, const void* data, size_t size, off64_t at, bool positioned) {
    Shim& s = shim();
    const std::string path = path_of(fd);
    if (!s.watched(path)) {
        return positioned ? ::syscall(SYS_pwrite64, fd, data, size, at)
                          : ::syscall(SYS_write, fd, data, size);
    }
    const std::lock_guard lock(s.mutex);
    if (const int error = s.failure("write", path, static_cast<long long>(size))) {
        errno = error;
        return -1;
    }
    const off64_t offset = positioned ? at : ::lseek64(fd, 0, SEEK_CUR);
    const ssize_t n = positioned ? ::syscall(SYS_pwrite64, fd, data, size, at)
                                 : ::syscall(SYS_write, fd, data, size);
    if (n > 0) {
        s.record(DiskOp::kWrite, path, "", static_cast<uint64_t>(offset), data,
                 static_cast<uint64_t>(n));
    }
    return n;
}

int sync_fd(int fd, long call) {
    Shim& s = shim();
    const std::string path = path_of(fd);
    const std::lock_guard lock(s.mutex);
    if (const int error = s.failure("sync", path, 0)) {
        errno = error;
        return -1;
    }
    const int result = static_cast<int>(::syscall(call, fd));
    if (result == 0) s.record(DiskOp::kSync, path, "", 0, nullptr, 0);
    return result;
}

int truncate_fd(int fd, off64_t size) {
    Shim& s = shim();
    const std::lock_guard lock(s.mutex);
    const int result = static_cast<int>(::syscall(SYS_ftruncate, fd, size));
    if (result == 0) {
        s.record(DiskOp::kTruncate, path_of(fd), "", static_cast<uint64_t>(size), nullptr, 0);
    }
    return result;
}

int open_path(const char* path, int flags, mode_t mode) {
    Shim& s = shim();
    if (!s.watched(path)) {
        return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
    }
    const std::lock_guard lock(s.mutex);
    struct stat info {};
    const bool existed = ::stat(path, &info) == 0;
    const bool creates = (flags & O_CREAT) != 0 && !existed;
    if (const int error = s.failure("open", path, creates ? 4096 : 0)) {
        errno = error;
        return -1;
    }
    const int fd = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
    if (fd >= 0 && creates) s.record(DiskOp::kCreate, path, "", 0, nullptr, 0);
    if (fd >= 0 && existed && (flags & O_TRUNC) != 0) {
        s.record(DiskOp::kTruncate, path, "", 0, nullptr, 0);
    }
    return fd;
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* data, size_t size) { return write_to(fd, data, size, 0, false); }
ssize_t pwrite(int fd, const void* data, size_t size, off_t at) {
    return write_to(fd, data, size, at, true);
}
ssize_t pwrite64(int fd, const void* data, size_t size, off64_t at) {
    return write_to(fd, data, size, at, true);
}
int fsync(int fd) { return sync_fd(fd, SYS_fsync); }
int fdatasync(int fd) { return sync_fd(fd, SYS_fdatasync); }
int ftruncate(int fd, off_t size) noexcept { return truncate_fd(fd, size); }
int ftruncate64(int fd, off64_t size) noexcept { return truncate_fd(fd, size); }

int open(const char* path, int flags, ...) {
    va_list args;
    va_start(args, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(args, mode_t) : 0;
    va_end(args);
    return open_path(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
    va_list args;
    va_start(args, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(args, mode_t) : 0;
    va_end(args);
    return open_path(path, flags, mode);
}

int rename(const char* from, const char* to) noexcept {
    Shim& s = shim();
    if (s.below_root(to) && !s.kill.empty() && std::string(to).find(s.kill) != std::string::npos) {
        ::kill(::getpid(), SIGKILL);
    }
    const std::lock_guard lock(s.mutex);
    if (const int error = s.failure("rename", to, 0)) {
        errno = error;
        return -1;
    }
    const int result = static_cast<int>(::syscall(SYS_rename, from, to));
    if (result == 0) s.record(DiskOp::kRename, from, to, 0, nullptr, 0);
    return result;
}

int unlink(const char* path) noexcept {
    Shim& s = shim();
    const std::lock_guard lock(s.mutex);
    const int result = static_cast<int>(::syscall(SYS_unlink, path));
    if (result == 0 && s.below_root(path)) {
        if (std::string(path).find("ballast") != std::string::npos) s.room = 16LL << 20;
        s.record(DiskOp::kUnlink, path, "", 0, nullptr, 0);
    }
    return result;
}

int mkdir(const char* path, mode_t mode) noexcept {
    Shim& s = shim();
    const std::lock_guard lock(s.mutex);
    if (const int error = s.failure("mkdir", path, 4096)) {
        errno = error;
        return -1;
    }
    const int result = static_cast<int>(::syscall(SYS_mkdir, path, mode));
    if (result == 0) s.record(DiskOp::kMakeFolder, path, "", 0, nullptr, 0);
    return result;
}

int statfs(const char* path, struct statfs* info) noexcept {
    static auto* const next = real<int(const char*, struct statfs*)>("statfs");
    static const std::string type = variable("SHIM_FS_TYPE");
    const int result = next(path, info);
    if (result == 0 && !type.empty() && shim().below_root(path)) {
        info->f_type = std::stol(type, nullptr, 16);
    }
    return result;
}

int clock_gettime(clockid_t clock, timespec* time) noexcept {
    static auto* const next = real<int(clockid_t, timespec*)>("clock_gettime");
    const int result = next(clock, time);
    static const std::string file = variable("SHIM_CLOCK");
    if (result == 0 && clock == CLOCK_REALTIME && !file.empty()) {
        std::array<char, 32> text{};
        const long fd = ::syscall(SYS_openat, AT_FDCWD, file.c_str(), O_RDONLY, 0);
        if (fd >= 0) {
            if (::syscall(SYS_read, fd, text.data(), text.size() - 1) > 0) {
                time->tv_sec += std::atol(text.data());
            }
            ::syscall(SYS_close, fd);
        }
    }
    return result;
}

}  // extern "C"
