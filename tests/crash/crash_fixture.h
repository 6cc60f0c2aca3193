// Programs under the shim, and stores that are looked at in a process of their own.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "promises.h"
#include "server/process.h"
#include "support/sanitized.h"

namespace probebake::test {

/// A length of a test: from the environment, else the short form.
inline int form(const char* variable, int short_form) {
    const char* text = std::getenv(variable);
    return text == nullptr ? short_form : std::atoi(text);
}

/// The program under the shim with these settings of it.
inline Process::Program shimmed(const std::string& path, std::vector<std::string> settings) {
    settings.emplace_back("LD_PRELOAD=" PROBEBAKE_SHIM);
    return {path, std::move(settings)};
}

/// Runs `check` in a child process; what it returns, or 100 + the signal that ended it.
inline int in_child(const std::function<int()>& check) {
    std::cout.flush();
    const pid_t pid = ::fork();
    if (pid == 0) ::_exit(check());
    int status = 0;
    ::waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 100 + WTERMSIG(status);
}

enum Verdict { kKept = 0, kBroken = 1, kUnusable = 2 };

/// Opens a store and compares it with what was promised.
inline int check_store(const std::filesystem::path& data, const Promises& promises, bool loud) {
    return in_child([&] {
        try {
            JobStore store(data, {});
            const std::vector<std::string> broken = promises.broken_by(store);
            for (size_t i = 0; loud && i < broken.size() && i < 5; ++i) {
                std::cerr << broken[i] << std::endl;
            }
            return broken.empty() ? kKept : kBroken;
        } catch (const std::exception& error) {
            if (loud) std::cerr << error.what() << std::endl;
            return kUnusable;
        }
    });
}

inline Promises read_promises(const std::string& text) {
    Promises promises;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) promises.add(line);
    return promises;
}

}  // namespace probebake::test
