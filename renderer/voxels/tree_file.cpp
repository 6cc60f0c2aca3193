#include "voxels/tree_file.h"

#include <array>
#include <span>
#include <utility>

#include "io/checked_file.h"

namespace probebake {
namespace {

constexpr std::string_view kKind = "voxtree";
constexpr uint64_t kVersion = 1;

struct Summary {
    uint64_t depth = 0;
    uint64_t voxels = 0;
    uint64_t octants = 0;
    double albedo_scale = 1.0;
    double emission_scale = 1.0;
};

ColorLevels read_colors(const CheckedFile& file, size_t first_section, double scale) {
    ColorLevels levels;
    levels.voxels = file.array<PackedRgb>(first_section);
    levels.octants = file.array<PackedRgb>(first_section + 1);
    levels.nodes = file.array<PackedRgb>(first_section + 2);
    levels.scale = static_cast<float>(scale);
    return levels;
}

bool fits(const ColorLevels& colors, const VoxelTree& tree) {
    return colors.voxels.size() == tree.voxel_count() &&
           colors.octants.size() == tree.octant_count() &&
           colors.nodes.size() == tree.nodes().size();
}

/// Every index of every node lies within the arrays, so that no traversal can leave them.
bool indices_fit(const VoxelTree& tree) {
    uint64_t octants = 0;
    for (int k = tree.node_levels() - 1; k >= 0; --k) {
        uint64_t next = k > 0 ? tree.level_begin(k - 1) : 0;
        for (const VoxelNode& node : tree.node_level(k)) {
            if (node.octant_base != octants) return false;
            if (node.mask != 0 && node.first_child != next) return false;
            octants += static_cast<uint64_t>(std::popcount(nonzero_bytes(node.mask)));
            next += static_cast<uint64_t>(std::popcount(node.mask));
        }
        const uint64_t below =
            k > 0 ? tree.level_begin(k - 1) + tree.node_level(k - 1).size() : tree.voxel_count();
        if (next != below) return false;
    }
    return octants == tree.octant_count();
}

}  // namespace

void save_tree(const std::filesystem::path& path, const VoxelTree& tree, const std::string& notes) {
    const ColorPyramid& colors = tree.colors();
    const Summary summary{.depth = static_cast<uint64_t>(tree.depth()),
                          .voxels = tree.voxel_count(),
                          .octants = tree.octant_count(),
                          .albedo_scale = colors.albedo.scale,
                          .emission_scale = colors.emission.scale};
    const std::array sections = {
        std::as_bytes(std::span(&summary, 1)), std::as_bytes(tree.nodes()),
        bytes_of(tree.level_begins()),         bytes_of(colors.albedo.voxels),
        bytes_of(colors.albedo.octants),       bytes_of(colors.albedo.nodes),
        bytes_of(colors.emission.voxels),      bytes_of(colors.emission.octants),
        bytes_of(colors.emission.nodes),       std::as_bytes(std::span(notes))};
    write_checked_file(path, kKind, kVersion, sections);
}

TreeFile load_tree(const std::filesystem::path& path) {
    const CheckedFile file(path, kKind, kVersion);
    const std::vector<Summary> summaries = file.array<Summary>(0);
    std::vector<VoxelNode> nodes = file.array<VoxelNode>(1);
    std::vector<uint64_t> level_begin = file.array<uint64_t>(2);
    const auto refuse = [&](const char* problem) { throw IoError(file.name(), problem); };
    if (summaries.size() != 1) refuse("has no summary");
    const Summary& summary = summaries[0];
    if (summary.depth < 2 || summary.depth > kMaxDepth ||
        level_begin.size() != (summary.depth + 1) / 2 + 1 || level_begin.front() != 0 ||
        level_begin.back() != nodes.size()) {
        refuse("has levels that do not fit its depth");
    }
    for (size_t i = 1; i < level_begin.size(); ++i) {
        if (level_begin[i] < level_begin[i - 1]) refuse("has levels out of order");
    }
    VoxelTree tree(static_cast<int>(summary.depth), std::move(nodes), std::move(level_begin),
                   summary.voxels, summary.octants);
    if (!indices_fit(tree)) refuse("has nodes whose children lie outside the tree");
    ColorPyramid colors;
    colors.albedo = read_colors(file, 3, summary.albedo_scale);
    colors.emission = read_colors(file, 6, summary.emission_scale);
    if (!fits(colors.albedo, tree) || !(colors.emission.empty() || fits(colors.emission, tree))) {
        refuse("has colours that do not fit its nodes");
    }
    tree.set_colors(std::move(colors));
    const std::vector<char> notes = file.array<char>(9);
    return {std::move(tree), std::string(notes.begin(), notes.end())};
}

}  // namespace probebake
