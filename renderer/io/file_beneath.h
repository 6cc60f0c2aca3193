// Files of a folder that others may write to: nothing in it leads out of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/io_error.h"

namespace probebake {

/// As read_file, of a file in its folder: refused where the name is a symbolic link or leads out of
/// the folder (openat2).
std::vector<std::byte> read_file_beneath(const std::filesystem::path& path,
                                         uint64_t max_bytes = uint64_t{1} << 36);

/// A file in the folder or in folders beneath it ("textures/wood.png"); no value where there is no
/// such file. Throws as above.
std::optional<std::vector<std::byte>> find_file_beneath(const std::filesystem::path& folder,
                                                        const std::string& name,
                                                        uint64_t max_bytes = uint64_t{1} << 36);

}  // namespace probebake
