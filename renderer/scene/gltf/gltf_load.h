// A glTF file as tinygltf has it, with all of its buffers.
//
// check_gltf has seen the document before. Pictures that stand in the file are kept as bytes
// (tinygltf::Image::image), whatever they are; those in files of their own are left where they are.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "scene/folder_files.h"
#include "scene/gltf/tinygltf.h"

namespace probebake {

/// Throws IoError. What tinygltf finds fault with and goes on is a warning.
tinygltf::Model load_gltf(std::span<const std::byte> bytes, const ReadInner& read,
                          const std::string& file, std::vector<std::string>& warnings);

}  // namespace probebake
