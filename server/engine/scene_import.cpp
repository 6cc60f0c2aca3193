#include "engine/scene_import.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "io/io_error.h"

namespace probebake {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kCancelInterval{50};
constexpr size_t kMaxReasonBytes = 1000;
constexpr rlim_t kMaxFiles = 64;

/// A child process whose standard error we read. Killed and reaped by the destructor.
class Child {
  public:
    explicit Child(std::vector<std::string> args) {
        std::array<int, 2> ends{};
        if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw IoError(args[0], "no pipe for an import");
        std::vector<char*> argv;
        argv.reserve(args.size() + 1);
        for (std::string& arg : args) argv.push_back(arg.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        ::posix_spawn_file_actions_init(&actions);
        ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
        // Connections and the database are none of its business.
        ::posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
        const int error = ::posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
        ::posix_spawn_file_actions_destroy(&actions);
        ::close(ends[1]);
        errors_ = ends[0];
        if (error != 0) {
            ::close(errors_);
            throw IoError(args[0], std::string("cannot be started: ") + std::strerror(error));
        }
    }
    ~Child() {
        if (!reaped_) {
            ::kill(pid_, SIGKILL);
            ::waitpid(pid_, &status_, 0);
        }
        ::close(errors_);
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Reads for a while; false once it has ended.
    bool runs(std::chrono::milliseconds time) {
        pollfd ready{errors_, POLLIN, 0};
        if (::poll(&ready, 1, static_cast<int>(time.count())) > 0) {
            std::array<char, 4096> buffer{};
            const ssize_t n = ::read(errors_, buffer.data(), buffer.size());
            if (n > 0) {
                text_.append(buffer.data(), static_cast<size_t>(n));
                text_.resize(std::min(text_.size(), kMaxReasonBytes));
                return true;
            }
            ::waitpid(pid_, &status_, 0);  // nobody writes any more: it ends
            reaped_ = true;
            return false;
        }
        return true;
    }
    int status() const { return status_; }
    const std::string& text() const { return text_; }

  private:
    pid_t pid_ = -1;
    int errors_ = -1;
    int status_ = 0;
    bool reaped_ = false;
    std::string text_;
};

std::string reason(const Child& child) {
    if (WIFSIGNALED(child.status())) {
        const int signal = WTERMSIG(child.status());
        if (signal == SIGXCPU) return "its import took more time than it may";
        if (signal == SIGXFSZ) return "its import wrote more than it may";
        return "its import crashed (signal " + std::to_string(signal) + ")";
    }
    std::string text = child.text();
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < ' ') c = ' ';
    }
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text.empty() ? "its import failed" : text;
}

/// Runs the child on a file; `more` goes to its command line.
void run_child(const ImportProcess& process, const std::filesystem::path& file,
               const std::vector<std::string>& more, const CancelToken& cancel) {
    const ImportLimits& limits = process.limits;
    const std::string name = file.stem().string();
    std::vector<std::string> args = {process.program.string(),
                                     "import-scene",
                                     file.string(),
                                     "--memory-mib",
                                     std::to_string(limits.memory_bytes >> 20),
                                     "--seconds",
                                     std::to_string(limits.time.count())};
    args.insert(args.end(), more.begin(), more.end());
    Child child(std::move(args));
    const Clock::time_point end = Clock::now() + limits.time;
    while (child.runs(kCancelInterval)) {
        cancel.throw_if_cancelled();
        if (Clock::now() > end) throw IoError(name, "its import took more time than it may");
    }
    if (child.status() != 0) throw IoError(name, reason(child));
}

}  // namespace

void import_in_process(const ImportProcess& process, const SceneFile& file,
                       const std::filesystem::path& cache_dir, const CancelToken& cancel) {
    run_child(process, file.folder / (file.name + ".json"), {"--cache", cache_dir.string()},
              cancel);
}

void import_archive_in_process(const ImportProcess& process, const std::filesystem::path& archive,
                               const std::filesystem::path& scene,
                               const std::filesystem::path& cache_dir, const CancelToken& cancel) {
    run_child(process, scene, {"--cache", cache_dir.string(), "--archive", archive.string()},
              cancel);
}

void import_sky_in_process(const ImportProcess& process, const std::filesystem::path& picture,
                           const std::filesystem::path& into, const CancelToken& cancel) {
    run_child(process, picture, {"--sky", into.string()}, cancel);
}

void limit_this_process(const ImportLimits& limits) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    const auto limit_from_to = [](auto resource, uint64_t soft, uint64_t hard) {
        const rlimit both{soft, hard};
        if (::setrlimit(resource, &both) != 0) {
            throw IoError("import", std::string("no limits: ") + std::strerror(errno));
        }
    };
    const auto limit = [&](auto resource, uint64_t value) {
        limit_from_to(resource, value, value);
    };
    limit(RLIMIT_CORE, 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they reserve terabytes
    limit(RLIMIT_AS, limits.memory_bytes);
#endif
    limit(RLIMIT_FSIZE, limits.memory_bytes);
    // All threads together. SIGXCPU comes at the soft limit and tells why; SIGKILL at the hard one.
    const uint64_t processors = std::max(1U, std::thread::hardware_concurrency());
    const uint64_t seconds = static_cast<uint64_t>(limits.time.count()) * processors;
    limit_from_to(RLIMIT_CPU, seconds, seconds + 1);
    limit(RLIMIT_NOFILE, kMaxFiles);
}

}  // namespace probebake
