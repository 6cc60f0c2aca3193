// Scenes as clients bring them: an uncompressed tar of one folder's files.
//
// Expected in it: "scene.json" (scene/scene_library.h has its fields) and the files that it and
// they name, plain files, also in folders ("./NAME" is NAME). Anything else is refused: links,
// devices, ways out, names that are none of a scene's, a name twice.
#pragma once

#include <filesystem>
#include <string>

namespace probebake {

/// Writes the archive's files into `folder`, scene.json as NAME.json, and makes them durable. What
/// they take together is not more than the archive itself. Throws IoError. Meant for a process
/// that has limits (scene_import.h).
void unpack_scene(const std::filesystem::path& archive, const std::filesystem::path& folder,
                  const std::string& name);

}  // namespace probebake
