// Whole files in and out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "io/io_error.h"

namespace probebake {

/// Throws IoError where the file cannot be read, is not a regular file or exceeds max_bytes.
std::vector<std::byte> read_file(const std::filesystem::path& path,
                                 uint64_t max_bytes = uint64_t{1} << 36);

/// Writes to a temporary file beside `path` and renames it, so that a reader sees the old file or
/// the whole new one. Throws IoError; leaves no temporary file behind.
void write_file_atomically(const std::filesystem::path& path,
                           std::span<const std::span<const std::byte>> parts);
void write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file_atomically(const std::filesystem::path& path, const std::string& text);

}  // namespace probebake
