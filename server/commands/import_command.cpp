// probebake import-scene SCENE.json: the process in which the service has files of other programs
// imported (engine/scene_import.h).
#include <algorithm>
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "engine/scene_archive.h"
#include "engine/scene_import.h"
#include "io/io_error.h"
#include "light/sky_file.h"

namespace probebake {
namespace {

struct ImportOptions {
    std::filesystem::path scene;
    std::filesystem::path cache;
    std::optional<std::filesystem::path> archive;
    std::optional<std::filesystem::path> sky;
    uint64_t memory_mib = 8192;
    int64_t seconds = 600;
};

/// Generated worlds are as large as one likes and made by the service itself: they come from its
/// own library only.
void refuse_generated(const SceneFile& file) {
    const bool generated =
        file.generator || std::any_of(file.media.begin(), file.media.end(),
                                      [](const MediumFile& medium) { return medium.cumulus; });
    if (generated) {
        throw IoError("scene.json", "expected a scene of files, nothing that is generated");
    }
}

/// Without the program's name in front: the reason becomes a job's.
int run_import(const ImportOptions& options) {
    try {
        limit_this_process({.memory_bytes = options.memory_mib << 20,
                            .time = std::chrono::seconds(options.seconds)});
        if (options.sky) {
            save_sky(*options.sky, read_sky_file(options.scene));
            return 0;
        }
        if (options.archive) {
            unpack_scene(*options.archive, options.scene.parent_path(),
                         options.scene.stem().string());
        }
        const SceneFile file = read_scene_file(options.scene);
        if (options.archive) refuse_generated(file);
        import_scene(file, options.cache);
        return 0;
    } catch (const std::bad_alloc&) {
        std::cerr << "its import needs more memory than it may\n";
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
    }
    return 1;
}

}  // namespace

void add_import_command(CLI::App& app, CommandWork& work) {
    auto* command =
        app.add_subcommand("import-scene", "Put a scene's tree into a cache, within limits");
    const auto options = std::make_shared<ImportOptions>();
    command->add_option("scene", options->scene, "Scene file, or picture of a sky")->required();
    command->add_option("--cache", options->cache, "Folder of the cache");
    command->add_option("--sky", options->sky, "Decode a picture to this file");
    command->add_option("--archive", options->archive, "Archive to unpack beside the scene file");
    command->add_option("--memory-mib", options->memory_mib, "Address space, MiB")
        ->check(CLI::Range(1, 1 << 30))
        ->capture_default_str();
    command->add_option("--seconds", options->seconds, "Time")
        ->check(CLI::Range(1, 1 << 30))
        ->capture_default_str();
    command->callback([options, &work] { work = [options] { return run_import(*options); }; });
}

}  // namespace probebake
