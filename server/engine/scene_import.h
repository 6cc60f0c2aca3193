// Import of a scene in a process of its own, with limits: what a hostile file does to an importer,
// it does to that process alone, and the job that asked for the scene fails with the reason.
//
//   parent: probebake import-scene SCENE.json --cache DIR --memory-mib N --seconds N
//   child:  limits itself, reads, builds the tree, writes it to DIR under the content's hash; or
//           says on standard error what is wrong, and ends with a code that is not 0
//   parent: reads the tree, which carries checksums (voxels/tree_file.h)
//
// With --archive FILE the child unpacks a client's archive (scene_archive.h) to SCENE.json's folder
// first.
#pragma once

#include <chrono>
#include <filesystem>

#include "io/cancel.h"
#include "scene/scene_library.h"

namespace probebake {

struct ImportLimits {
    uint64_t memory_bytes = uint64_t{8} << 30;  // of address space, and of the file written
    std::chrono::seconds time{600};             // of the wall, and as much of every processor
};

struct ImportProcess {
    std::filesystem::path program;  // this one's, as a rule
    std::filesystem::path scratch;  // where trees go through if they are kept nowhere
    ImportLimits limits;
};

/// Throws IoError with the reason, and Cancelled; the process is gone in any case.
void import_in_process(const ImportProcess& process, const SceneFile& file,
                       const std::filesystem::path& cache_dir, const CancelToken& cancel);

/// The same of an archive, which becomes the scene file `scene` and its files beside it.
void import_archive_in_process(const ImportProcess& process, const std::filesystem::path& archive,
                               const std::filesystem::path& scene,
                               const std::filesystem::path& cache_dir, const CancelToken& cancel);

/// Decodes the picture of a sky to the file `into` (light/sky_file.h). Throws the same.
void import_sky_in_process(const ImportProcess& process, const std::filesystem::path& picture,
                           const std::filesystem::path& into, const CancelToken& cancel);

/// What the child does with itself before it opens anything.
void limit_this_process(const ImportLimits& limits);

}  // namespace probebake
