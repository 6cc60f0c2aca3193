// A folder for targets that read files: in memory where there is such a one, since a fuzzer writes
// to it a thousand times a second. Gone with its object.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>

struct MemoryFolder {
    const std::filesystem::path path =
        (std::filesystem::exists("/dev/shm") ? "/dev/shm"
                                             : std::filesystem::temp_directory_path()) /
        std::filesystem::path("probebake-fuzz-" + std::to_string(::getpid()));

    MemoryFolder() { std::filesystem::create_directories(path); }
    ~MemoryFolder() {
        std::error_code error;
        std::filesystem::remove_all(path, error);
    }
    MemoryFolder(const MemoryFolder&) = delete;
    MemoryFolder& operator=(const MemoryFolder&) = delete;
};
