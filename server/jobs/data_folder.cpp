#include "jobs/data_folder.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "io/io_error.h"
#include "jobs/job.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;

fs::path made(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder / "jobs", error);
    if (error) throw IoError(folder.string(), "cannot be used for data: " + error.message());
    return folder;
}

int locked(const fs::path& folder) {
    const int fd =
        ::open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
    if (fd < 0) {
        throw IoError(folder.string(),
                      std::string("cannot be used for data: lock: ") + std::strerror(errno));
    }
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
        const int error = errno;
        const Descriptor closes(fd);
        throw IoError(folder.string(),
                      error == EWOULDBLOCK
                          ? "is the data directory of another running service"
                          : std::string("cannot be locked: ") + std::strerror(error));
    }
    return fd;
}

void remove_old_jobs(const fs::path& jobs) {
    std::error_code error;
    for (fs::directory_iterator at(jobs, error), end; !error && at != end; at.increment(error)) {
        const fs::path path = at->path();
        std::error_code ignored;
        // A link is not followed: what it points to is not ours.
        const bool folder = fs::symlink_status(path, ignored).type() == fs::file_type::directory;
        if (folder && is_job_id(path.filename().string())) fs::remove_all(path, error);
    }
    if (error) throw IoError(jobs.string(), "cannot be cleared: " + error.message());
}

}  // namespace

DataFolder::DataFolder(const fs::path& folder) : folder_(made(folder)), lock_(locked(folder)) {
    remove_old_jobs(jobs());
}

}  // namespace probebake
