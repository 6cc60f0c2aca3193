// The contents of a MagicaVoxel .vox file: read and checked, not yet placed in a world.
//
//   "VOX ", version (150 or 200), chunk MAIN
//   chunk: id (4 characters), bytes of its content, bytes of its children, content, children
//
// All chunks of interest are children of MAIN. Coordinates are the file's: +Z up, right-handed, one
// voxel to the unit. Unknown chunks are passed over; the others have to be as documented in
// MagicaVoxel-file-format-vox.txt and -vox-extension.txt (github.com/ephtracy/voxel-model).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "math/vec.h"
#include "scene/vox/vox_dictionary.h"
#include "scene/vox/vox_palette.h"

namespace probebake {

struct VoxModelVoxel {
    std::array<uint8_t, 3> position{};
    uint8_t color = 0;  // 1..255
};

/// SIZE and XYZI. Positions are distinct and within the size; of several voxels at a position the
/// last one of the file counts, and colour 0 means empty.
struct VoxModel {
    uint64_t offset_bytes = 0;  // of its XYZI chunk
    IVec3 size{0};              // 1..256
    IVec3 lowest{0};            // bounds of the voxels, both inclusive; 0 where there are none
    IVec3 highest{0};
    std::vector<VoxModelVoxel> voxels;
};

/// nTRN, nGRP or nSHP.
struct VoxNode {
    enum class Kind { kTransform, kGroup, kShape };
    Kind kind = Kind::kTransform;
    int32_t id = 0;
    uint64_t offset_bytes = 0;  // of its chunk
    bool hidden = false;        // by itself or by its layer
    int32_t layer = -1;         // transforms only; -1 for none
    VoxTransform transform;     // transforms only
    /// Indices into VoxFile::nodes (transform: one child, group: any number) or into
    /// VoxFile::models (shape: one model per frame of its animation, at least one).
    std::vector<uint32_t> references;
};

/// "chunk nGRP: node 3", for messages.
std::string name_of(const VoxNode& node);

struct VoxFile {
    std::vector<VoxModel> models;
    std::vector<VoxNode> nodes;         // by ascending id; the root is the first, with id 0
    VoxPalette palette{};               // by VoxModelVoxel::color
    VoxMaterials materials{};           // likewise
    std::vector<std::string> warnings;  // each kind at most once
};

/// Largest size of a model: positions are bytes.
inline constexpr int kMaxVoxModelSize = 256;

/// Throws IoError with the chunk and the offset for whatever is not as documented. Takes at most
/// about a dozen bytes of memory per byte of the file (for nothing but nodes).
VoxFile parse_vox(std::span<const std::byte> bytes, const std::string& file_name);

}  // namespace probebake
