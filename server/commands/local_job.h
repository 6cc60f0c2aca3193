// What the commands that work without a service share: options, scenes by name or by file, the job.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "bake/job_spec.h"
#include "scene/scene_library.h"

namespace probebake {

/// Number of threads that this machine lets us use.
int available_threads();

/// Options of a command that loads scenes.
struct SceneOptions {
    std::filesystem::path scenes = "configs/scenes";
    std::optional<std::filesystem::path> cache;
    int threads = available_threads();

    void add_to(CLI::App& command);
};

/// A scene named in the library, or the path of a scene file. Throws IoError or SpecError.
SceneFile find_scene(const SceneOptions& options, const std::string& name_or_path);

/// A job file. Throws IoError or SpecError.
JobSpec read_job_file(const std::filesystem::path& path);

}  // namespace probebake
