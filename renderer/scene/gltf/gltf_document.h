// A glTF 2.0 document, checked before tinygltf reads it.
//
// tinygltf passes over fields of the wrong type, cuts integers to 32 bits, follows the offsets of a
// picture's buffer view and the length of a GLB's second chunk beyond their ends. All of that is
// refused here, with the file and the JSON pointer: the form of every field that the importer uses,
// every index, every buffer view, extensions that would have to be understood. What accessors say
// about bytes is gltf_accessor.h's business. Source: glTF 2.0 (Khronos), sections 3 and 4.4.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/io_error.h"

namespace probebake {

struct GltfDocument {
    /// Names of the files that hold its buffers and pictures, in its order, percent signs decoded.
    std::vector<std::string> buffers;
    std::vector<std::string> images;
    bool is_binary = false;
};

/// Of a .gltf or .glb file. Throws IoError.
GltfDocument check_gltf(std::span<const std::byte> bytes, const std::string& file);

/// Whether the importer does what an extension asks for.
bool gltf_understands(const std::string& extension);

/// A URI that names a file, percent signs decoded; no value for data: URIs. Throws IoError, naming
/// file and pointer, where it is neither, or leads out of the file's folder.
std::optional<std::string> name_of_uri(const std::string& uri, const std::string& pointer,
                                       const std::string& file);

}  // namespace probebake
