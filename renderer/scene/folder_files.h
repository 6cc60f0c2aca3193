// The files that a mesh refers to: buffers, materials, textures, by names relative to its folder.
//
// Names are written by whoever made the mesh: they may lead into folders beneath the scene's, never
// out of it, and are never expanded.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/io_error.h"

namespace probebake {

/// The file of a name that is_inner_name accepts; no value where there is none. Throws IoError.
using ReadInner = std::function<std::optional<std::vector<std::byte>>(const std::string& name)>;

/// Parts between '/', of 1 to 255 bytes and 1024 in all; none is "." or ".."; no backslash, colon
/// or control character.
bool is_inner_name(std::string_view name);

/// Of a folder; nothing in it leads out of it. A file of more than 1 GiB is an IoError.
ReadInner files_beneath(std::filesystem::path folder);

/// As read(name), but a name that is_inner_name does not accept is an IoError that names `file`,
/// in which it stands.
std::optional<std::vector<std::byte>> read_inner(const ReadInner& read, const std::string& name,
                                                 const std::string& file);

}  // namespace probebake
