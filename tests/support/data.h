// Real scenes for tests. They are no part of the repository: a test that needs one skips without.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace probebake::test {

/// The file of that name ("vox/worldA_2048.vox") in the directory named by the environment variable
/// PROBEBAKE_DATA, by default ../shared/data beside the sources; no value where there is none.
inline std::optional<std::filesystem::path> data_file(const std::string& name) {
    const char* directory = std::getenv("PROBEBAKE_DATA");
    const std::filesystem::path root =
        directory != nullptr ? std::filesystem::path(directory)
                             : std::filesystem::path(PROBEBAKE_SOURCE_DIR) / "../shared/data";
    const std::filesystem::path path = root / name;
    if (!std::filesystem::is_regular_file(path)) return std::nullopt;
    return path;
}

}  // namespace probebake::test
