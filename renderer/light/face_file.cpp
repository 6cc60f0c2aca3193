#include "light/face_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "io/checked_file.h"

namespace probebake {
namespace {

constexpr std::string_view kKind = "light";
constexpr uint64_t kVersion = 1;
constexpr size_t kSectionsPerLevel = 5;

struct Summary {
    double scale = 1.0;
    LightingCost cost;
};

/// The values of every word begin where those of the one before end, so that no index leaves them.
bool fits(const FaceLevel& level, size_t nodes, bool is_voxels) {
    const size_t words = (nodes + 7) / 8;
    if (level.exposed.size() != 8 * words || level.first.size() != words) return false;
    uint64_t next = 0;
    for (size_t w = 0; w < words; ++w) {
        if (level.first[w] != next) return false;
        next += static_cast<uint64_t>(std::popcount(level.word(8 * w)));
    }
    if (next != level.values.size()) return false;
    if (is_voxels) return level.groups.empty() && level.divided.empty();
    return level.groups.size() == level.values.size() && level.divided.size() >= nodes;
}

FaceLevel read_level(const CheckedFile& file, size_t first) {
    return {.exposed = file.array<uint8_t>(first),
            .first = file.array<uint32_t>(first + 1),
            .values = file.array<PackedRgb>(first + 2),
            .groups = file.array<FaceGroup>(first + 3),
            .divided = file.array<uint8_t>(first + 4)};
}

}  // namespace

void save_light(const std::filesystem::path& path, const LitScene& lit) {
    const std::array<Summary, 1> summary{{{double{lit.colors.scale}, lit.cost}}};
    std::vector<std::span<const std::byte>> sections = {std::as_bytes(std::span(summary))};
    sections.reserve(1 + 3 * kSectionsPerLevel);
    for (const FaceLevel* level : {&lit.colors.voxels, &lit.colors.octants, &lit.colors.nodes}) {
        sections.push_back(bytes_of(level->exposed));
        sections.push_back(bytes_of(level->first));
        sections.push_back(bytes_of(level->values));
        sections.push_back(bytes_of(level->groups));
        sections.push_back(bytes_of(level->divided));
    }
    write_checked_file(path, kKind, kVersion, sections);
}

LitScene load_light(const std::filesystem::path& path, const VoxelTree& tree) {
    const CheckedFile file(path, kKind, kVersion);
    if (file.section_count() != 1 + 3 * kSectionsPerLevel) {
        throw IoError(file.name(), "expected 16 sections");
    }
    const std::vector<Summary> summary = file.array<Summary>(0);
    LitScene lit;
    lit.colors.voxels = read_level(file, 1);
    lit.colors.octants = read_level(file, 1 + kSectionsPerLevel);
    lit.colors.nodes = read_level(file, 1 + 2 * kSectionsPerLevel);
    const bool good = summary.size() == 1 && summary[0].scale > 0.0 &&
                      std::isfinite(summary[0].scale) &&
                      fits(lit.colors.voxels, tree.voxel_count(), true) &&
                      fits(lit.colors.octants, tree.octant_count(), false) &&
                      fits(lit.colors.nodes, tree.nodes().size(), false);
    if (!good) throw IoError(file.name(), "arrays that do not fit together, or not the tree");
    lit.colors.scale = static_cast<float>(summary[0].scale);
    lit.cost = summary[0].cost;
    return lit;
}

}  // namespace probebake
