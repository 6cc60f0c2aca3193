// What is known of the real .vox files (MANIFEST.md of the scene data, "Known answers").
#pragma once

#include <gtest/gtest.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <string>

#include "io/file.h"
#include "scene/vox/vox_import.h"
#include "support/data.h"

namespace probebake::test {

struct VoxFacts {
    std::string name;
    uint64_t distinct_positions;
    IVec3 lowest;  // file coordinates, Z up
    IVec3 extent;
    uint64_t hash;
    uint64_t models;
    uint64_t instances;
    uint64_t rotated;
    uint64_t emissive;
};

/// Imports the file and compares; skips the test where there is no data.
inline void expect_facts(const VoxFacts& facts) {
    const auto path = data_file("vox/" + facts.name + ".vox");
    if (!path) GTEST_SKIP() << "no scene data: set PROBEBAKE_DATA";
    const VoxImport result = import_vox(read_file(*path), facts.name);
    EXPECT_EQ(result.models, facts.models);
    EXPECT_EQ(result.instances, facts.instances);
    EXPECT_EQ(result.rotated_instances, facts.rotated);
    EXPECT_EQ(result.hidden_instances, 0u);
    EXPECT_EQ(result.emissive_voxels, facts.emissive);

    std::vector<uint64_t> codes;
    codes.reserve(result.cloud.voxels.size());
    for (const Voxel& voxel : result.cloud.voxels) codes.push_back(voxel.morton());
    tbb::parallel_sort(codes);
    codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
    EXPECT_EQ(codes.size(), facts.distinct_positions);

    IVec3 highest(0);
    for (const uint64_t code : codes) highest = glm::max(highest, morton_decode(code));
    EXPECT_EQ(IVec3(highest.x + 1, highest.z + 1, highest.y + 1), facts.extent);
    // The lowest y of the file is the highest z of ours.
    EXPECT_EQ(IVec3(result.lowest.x, -(result.lowest.z + highest.z) - 1, result.lowest.y),
              facts.lowest);

    uint64_t sum = 0;
    for (const uint64_t code : codes) {
        const IVec3 p = morton_decode(code);
        const auto key = static_cast<uint64_t>(p.x) | static_cast<uint64_t>(highest.z - p.z) << 16 |
                         static_cast<uint64_t>(p.y) << 32;
        uint64_t h = key * 0x9E37'79B9'7F4A'7C15;
        h ^= h >> 29;
        h *= 0xBF58'476D'1CE4'E5B9;
        h ^= h >> 32;
        sum += h;
    }
    EXPECT_EQ(sum, facts.hash) << std::hex << sum;
}

}  // namespace probebake::test
