#include "store/data_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "io/io_error.h"
#include "store/sqlite.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& folder, const std::string& problem) {
    throw IoError(folder.string(), "cannot be used for data: " + problem);
}

/// File systems of other machines, by their magic numbers (statfs(2)): NFS, SMB, CIFS, SMB2, AFS,
/// Coda, NCP, 9P, Ceph, FUSE (sshfs and the like).
constexpr std::array<uint32_t, 10> kNetworkTypes = {0x6969,     0x517b,     0xff534d42, 0xfe534d42,
                                                    0x5346414f, 0x73757245, 0x564c,     0x01021997,
                                                    0x00c36400, 0x65735546};

fs::path made(const fs::path& folder) {
    std::error_code error;
    const bool is_new = fs::create_directories(folder, error);
    if (error) refuse(folder, error.message());
    if (is_new) sync_folder(fs::absolute(folder).lexically_normal().parent_path());
    struct statfs info {};
    if (::statfs(folder.c_str(), &info) != 0) refuse(folder, std::strerror(errno));
    const auto type = static_cast<uint32_t>(info.f_type);
    if (std::find(kNetworkTypes.begin(), kNetworkTypes.end(), type) != kNetworkTypes.end()) {
        refuse(folder, "it lies on a network file system, expected a local one");
    }
    return folder;
}

int locked(const fs::path& folder) {
    const int fd =
        ::open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
    if (fd < 0) refuse(folder, std::string("lock: ") + std::strerror(errno));
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
        const int error = errno;
        const Descriptor closes(fd);
        if (error != EWOULDBLOCK) refuse(folder, std::string("lock: ") + std::strerror(error));
        throw IoError(folder.string(), "is the data directory of another running service");
    }
    return fd;
}

/// Makes a folder in the data folder where it is not yet; it must be one to write in.
void make_folder(const DataFolder& data, const fs::path& folder) {
    std::error_code error;
    fs::create_directory(folder, error);
    if (error) refuse(data.path(), error.message());
    if (::access(folder.c_str(), W_OK | X_OK) == 0) return;
    const char* problem = std::strerror(errno);
    refuse(data.path(), folder.lexically_relative(data.path()).string() + ": " + problem);
}

void make_folders(const DataFolder& data) {
    make_folder(data, data.temporary());
    make_folder(data, data.files());
    make_folder(data, data.scenes());
    constexpr const char* kDigits = "0123456789abcdef";
    for (int i = 0; i < 256; ++i) {
        make_folder(data, data.files() / std::string{kDigits[i / 16], kDigits[i % 16]});
    }
    std::error_code error;
    for (fs::directory_iterator at(data.temporary(), error), end; !error && at != end;
         at.increment(error)) {
        fs::remove_all(at->path(), error);
    }
    if (error) refuse(data.path(), error.message());
    // That it can be written is better known now than with the first probe.
    const Descriptor probe(::open((data.temporary() / "probe").c_str(),
                                  O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (probe.get() < 0) refuse(data.path(), std::strerror(errno));
    ::unlink((data.temporary() / "probe").c_str());
    sync_folder(data.files());
    sync_folder(data.path());
}

}  // namespace

void sync_folder(const fs::path& folder) {
    const Descriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (fd.get() < 0 || ::fsync(fd.get()) != 0) {
        fail_stop(folder.filename().string() + ": cannot be made durable: " + std::strerror(errno));
    }
}

DataFolder::DataFolder(const fs::path& folder) : folder_(made(folder)), lock_(locked(folder)) {
    make_folders(*this);
    restore_ballast();
}

uint64_t DataFolder::free_bytes() const {
    struct statvfs info {};
    if (::statvfs(folder_.c_str(), &info) != 0) return 0;
    return uint64_t{info.f_bavail} * info.f_frsize;
}

bool DataFolder::is_writable() const { return ::access(database().c_str(), W_OK) == 0; }

bool DataFolder::drop_ballast() const { return ::unlink((folder_ / "ballast").c_str()) == 0; }

bool DataFolder::restore_ballast() const {
    const fs::path path = folder_ / "ballast";
    if (::access(path.c_str(), F_OK) == 0) return true;
    if (free_bytes() < 2 * kBallastBytes) return false;
    const Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644));
    if (file.get() < 0) return false;
    if (::posix_fallocate(file.get(), 0, static_cast<off_t>(kBallastBytes)) == 0) return true;
    ::unlink(path.c_str());
    return false;
}

}  // namespace probebake
