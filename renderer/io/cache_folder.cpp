#include "io/cache_folder.h"

#include <algorithm>
#include <system_error>
#include <vector>

namespace probebake {

namespace fs = std::filesystem;

void mark_used(const fs::path& file) {
    std::error_code error;
    fs::last_write_time(file, fs::file_time_type::clock::now(), error);
}

void trim_cache(const fs::path& folder, uint64_t most_bytes) {
    struct Kept {
        fs::file_time_type used;
        uint64_t bytes = 0;
        fs::path path;
    };
    std::vector<Kept> files;
    uint64_t bytes = 0;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        std::error_code gone;
        Kept file{at->last_write_time(gone), at->file_size(gone), at->path()};
        if (gone || !at->is_regular_file(gone)) continue;
        bytes += file.bytes;
        files.push_back(std::move(file));
    }
    std::sort(files.begin(), files.end(),
              [](const Kept& a, const Kept& b) { return a.used < b.used; });
    for (const Kept& file : files) {
        if (bytes <= most_bytes) return;
        std::error_code gone;
        if (fs::remove(file.path, gone)) bytes -= file.bytes;
    }
}

}  // namespace probebake
