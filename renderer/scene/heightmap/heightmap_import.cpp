#include "scene/heightmap/heightmap_import.h"

#include <algorithm>
#include <cmath>

#include "io/io_error.h"
#include "math/srgb.h"

namespace probebake {
namespace {

constexpr int kMaxHeightLog2 = 16;

std::string size_text(int width_px, int height_px) {
    return std::to_string(width_px) + " x " + std::to_string(height_px);
}

/// Heights in voxels, at least 1.
class Columns {
  public:
    Columns(int width, int depth, std::vector<int> tops)
        : width_(width), depth_(depth), tops_(std::move(tops)) {}

    int width() const { return width_; }
    int depth() const { return depth_; }
    int top(int x, int z) const {
        return tops_[static_cast<size_t>(z) * static_cast<size_t>(width_) + static_cast<size_t>(x)];
    }
    /// Number of voxels of a column that are made, counted from its top.
    int shell(int x, int z) const {
        const int own = top(x, z);
        int lowest = own;
        if (x > 0) lowest = std::min(lowest, top(x - 1, z));
        if (x + 1 < width_) lowest = std::min(lowest, top(x + 1, z));
        if (z > 0) lowest = std::min(lowest, top(x, z - 1));
        if (z + 1 < depth_) lowest = std::min(lowest, top(x, z + 1));
        return own - lowest + 1;
    }
    int highest() const { return *std::max_element(tops_.begin(), tops_.end()); }

  private:
    int width_;
    int depth_;
    std::vector<int> tops_;
};

void require_height(double voxels, const std::string& file) {
    constexpr double kMost = 1 << kMaxHeightLog2;
    if (!(voxels <= kMost)) {
        throw IoError(file, "its highest column would have " + std::to_string(voxels) +
                                " voxels, expected at most " + std::to_string(kMost));
    }
}

/// The voxels that can be seen.
VoxelCloud make_voxels(const Columns& columns, const std::optional<ColorPicture>& colors,
                       uint64_t max_voxels, const std::string& file_name) {
    const int width = columns.width();
    const int depth = columns.depth();
    if (colors && (colors->width_px != width || colors->height_px != depth)) {
        throw IoError(file_name, "is " + size_text(width, depth) + " pixels, its colours are " +
                                     size_text(colors->width_px, colors->height_px) +
                                     ", expected the same");
    }
    uint64_t count = 0;
    for (int z = 0; z < depth; ++z) {
        for (int x = 0; x < width; ++x) count += static_cast<uint64_t>(columns.shell(x, z));
    }
    if (count > max_voxels) {
        throw IoError(file_name, "would become " + std::to_string(count) +
                                     " voxels, expected at most " + std::to_string(max_voxels));
    }
    VoxelCloud cloud;
    cloud.depth = depth_for_extent({width, columns.highest(), depth});
    cloud.voxels.reserve(count);
    for (int z = 0; z < depth; ++z) {
        for (int x = 0; x < width; ++x) {
            PackedRgb albedo = pack_rgb(kBareHeightmapAlbedo);
            if (colors) {
                const auto& c = colors->values[static_cast<size_t>(z) * static_cast<size_t>(width) +
                                               static_cast<size_t>(x)];
                albedo =
                    pack_rgb({srgb_to_linear(c[0]), srgb_to_linear(c[1]), srgb_to_linear(c[2])});
            }
            const int top = columns.top(x, z);
            for (int i = 0; i < columns.shell(x, z); ++i) {
                cloud.voxels.push_back(make_voxel({x, top - 1 - i, z}, albedo));
            }
        }
    }
    return cloud;
}

}  // namespace

VoxelCloud import_heightmap(const GreyPicture& heights, const std::optional<ColorPicture>& colors,
                            const HeightmapParams& params, const std::string& file_name) {
    const double voxels_per_count = params.height_scale_m / params.voxel_size_m;
    const auto highest = std::max_element(heights.values.begin(), heights.values.end());
    require_height(std::round(*highest * voxels_per_count), file_name);
    std::vector<int> tops(heights.values.size());
    for (size_t i = 0; i < tops.size(); ++i) {
        const auto rounded = static_cast<int>(std::lround(heights.values[i] * voxels_per_count));
        tops[i] = std::max(1, rounded);
    }
    return make_voxels({heights.width_px, heights.height_px, std::move(tops)}, colors,
                       params.max_voxels, file_name);
}

Terrain import_heightmap(const HeightPicture& heights, const std::optional<ColorPicture>& colors,
                         const HeightmapParams& params, const std::string& file_name) {
    const double voxels_per_unit = params.height_scale_m / params.voxel_size_m;
    const auto [low, high] = std::minmax_element(heights.values.begin(), heights.values.end());
    // The lowest column has the one voxel below its height.
    const double base = std::round(*low * voxels_per_unit) - 1.0;
    require_height(std::round(*high * voxels_per_unit) - base, file_name);
    if (!(std::abs(base) <= 1e9)) {
        throw IoError(file_name, "lies " + std::to_string(base) +
                                     " voxels from height 0, expected at most 1e9");
    }
    std::vector<int> tops(heights.values.size());
    for (size_t i = 0; i < tops.size(); ++i) {
        tops[i] = static_cast<int>(std::round(heights.values[i] * voxels_per_unit) - base);
    }
    return {make_voxels({heights.width_px, heights.height_px, std::move(tops)}, colors,
                        params.max_voxels, file_name),
            {0, static_cast<int>(base), 0}};
}

}  // namespace probebake
