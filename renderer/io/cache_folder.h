// A folder of files that can be made again: what was not used for longest goes first.
#pragma once

#include <cstdint>
#include <filesystem>

namespace probebake {

/// The file was of use just now.
void mark_used(const std::filesystem::path& file);

/// Removes files until all of them together take no more than `most_bytes`. What others do in the
/// folder meanwhile is no error.
void trim_cache(const std::filesystem::path& folder, uint64_t most_bytes);

}  // namespace probebake
