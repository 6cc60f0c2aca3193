// The generated worlds: names, descriptions, and one function that makes them.
//
// A world depends on (name, size, seed) alone, never on the number of threads. Landscapes measure
// 512 m × 512 m at every size (at 2048 voxels one is 25 cm, as in Müller 2020, chapter 4); the
// study scenes and shapes are built of 25 cm voxels. +Y is up.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "voxels/voxel_cloud.h"

namespace probebake {

struct GeneratorParams {
    std::string name;
    int size = 256;  // side of the world in voxels, a power of two
    uint64_t seed = 1;
};

struct GeneratorInfo {
    std::string_view name;
    std::string_view description;
    int min_size;
    int max_size;
};

/// All generators, landscapes first.
std::span<const GeneratorInfo> generators();

/// Throws std::invalid_argument, saying what was expected, for an unknown name or a bad size.
/// Parallel on the calling arena.
VoxelCloud generate(const GeneratorParams& params);

/// Edge of a voxel of that world in metres. Throws as generate() does.
double voxel_size_m(const GeneratorParams& params);

}  // namespace probebake
