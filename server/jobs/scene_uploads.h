// Scenes that clients bring: unpacked and tried by a process with limits, then in the data folder,
// durable, and replaced whole or not at all.
//
//   archive -> DATA/temporary/…: child unpacks, reads and imports -> rename -> DATA/scenes/NAME/
//
// Threads: everything may be called from any thread; uploads are taken one at a time.
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "engine/scene_import.h"
#include "store/data_folder.h"

namespace probebake {

class SceneUploads {
  public:
    /// `cache_dir` keeps trees; none: they are made again when a job asks for the scene.
    SceneUploads(const DataFolder& data, std::optional<ImportProcess> importer,
                 std::optional<std::filesystem::path> cache_dir);

    /// Whether the scene was there before: then it was replaced. Throws IoError with what is wrong
    /// with the archive, and Cancelled.
    bool put(const std::string& name, const std::filesystem::path& archive,
             const CancelToken& cancel);
    /// False where there is no such scene.
    bool remove(const std::string& name);
    /// Whether there is such a scene.
    bool has(const std::string& name) const;

  private:
    const DataFolder& data_;
    const std::optional<ImportProcess> importer_;
    const std::optional<std::filesystem::path> cache_dir_;
    std::mutex mutex_;
};

}  // namespace probebake
