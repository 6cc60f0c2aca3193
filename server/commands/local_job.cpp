#include "commands/local_job.h"

#include <sched.h>

#include <algorithm>

#include "io/file.h"

namespace probebake {

int available_threads() {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (::sched_getaffinity(0, sizeof(set), &set) != 0) return 1;
    return std::max(1, CPU_COUNT(&set));
}

void SceneOptions::add_to(CLI::App& command) {
    command.add_option("--scenes", scenes, "Folder of scene files")->capture_default_str();
    command.add_option("--cache", cache, "Folder that keeps built voxel trees between runs");
    command.add_option("--threads", threads, "Render threads")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
}

SceneFile find_scene(const SceneOptions& options, const std::string& name_or_path) {
    if (!is_name(name_or_path) || std::filesystem::is_regular_file(name_or_path)) {
        return read_scene_file(name_or_path);
    }
    const SceneLibrary library(options.scenes);
    if (std::optional<SceneFile> file = library.find(name_or_path)) return *file;
    std::string known;
    for (const std::string& name : library.names()) known += (known.empty() ? "" : ", ") + name;
    throw IoError(name_or_path,
                  "no such scene in " + options.scenes.string() + ", which holds: " + known);
}

JobSpec read_job_file(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = read_file(path, uint64_t{64} << 20);
    return read_job(parse_json({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
}

}  // namespace probebake
