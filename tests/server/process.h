// The real binary as a process of its own.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "support/temp_folder.h"

namespace probebake::test {

class Process {
  public:
    struct Program {
        std::string path = PROBEBAKE_BINARY;
        std::vector<std::string> environment = {};  // "NAME=value", besides ours
    };
    /// Starts probebake with these arguments; what it writes goes into files of the folder.
    Process(const std::filesystem::path& folder, std::vector<std::string> args)
        : Process(folder, std::move(args), Program{}) {}
    Process(const std::filesystem::path& folder, std::vector<std::string> args, Program program)
        : out_(folder / "stdout"), err_(folder / "stderr") {
        std::filesystem::create_directories(folder);
        args.insert(args.begin(), program.path);
        std::vector<char*> argv;
        argv.reserve(args.size() + 1);
        for (std::string& arg : args) argv.push_back(arg.data());
        argv.push_back(nullptr);
        std::vector<char*> variables;
        for (char** at = environ; *at != nullptr; ++at) variables.push_back(*at);
        for (std::string& variable : program.environment) variables.push_back(variable.data());
        variables.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        ::posix_spawn_file_actions_init(&actions);
        constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC;
        ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_.c_str(), kFlags, 0644);
        ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err_.c_str(), kFlags, 0644);
        const int error =
            ::posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), variables.data());
        ::posix_spawn_file_actions_destroy(&actions);
        if (error != 0) throw std::runtime_error("cannot start " + args[0]);
    }
    ~Process() {
        if (!code_) ::kill(pid_, SIGKILL);
        wait(std::chrono::seconds(10));
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    pid_t pid() const { return pid_; }
    void signal(int number) const { ::kill(pid_, number); }
    /// Ends it in order, so that it ends its own children: nginx's workers outlive a killed master.
    void end() {
        signal(SIGTERM);
        wait(std::chrono::seconds(30));
    }
    /// The exit code; -1 where a signal ended it; no value where it still runs after that time.
    std::optional<int> wait(std::chrono::milliseconds time = std::chrono::seconds(60)) {
        const auto end = std::chrono::steady_clock::now() + time;
        while (!code_) {
            int status = 0;
            if (::waitpid(pid_, &status, WNOHANG) == pid_) {
                code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
            } else if (std::chrono::steady_clock::now() > end) {
                return std::nullopt;
            } else {
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
            }
        }
        return code_;
    }
    std::string out() const { return read_text(out_); }
    std::string err() const { return read_text(err_); }

  private:
    std::filesystem::path out_;
    std::filesystem::path err_;
    pid_t pid_ = -1;
    std::optional<int> code_;
};

}  // namespace probebake::test
