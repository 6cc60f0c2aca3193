// Files of a folder that others may write to: nothing in it leads out of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "io/io_error.h"

namespace probebake {

/// As read_file, of a file in its folder: refused where the name is a symbolic link or leads out of
/// the folder (openat2).
std::vector<std::byte> read_file_beneath(const std::filesystem::path& path,
                                         uint64_t max_bytes = uint64_t{1} << 36);

}  // namespace probebake
