#include "light/face_sums.h"

#include <tbb/parallel_for.h>

#include <span>
#include <stdexcept>

namespace probebake {
namespace {

void index_values(FaceLevel& level) {
    level.exposed.resize((level.exposed.size() + 7) / 8 * 8, 0);
    level.first.resize(level.exposed.size() / 8);
    uint64_t count = 0;
    for (size_t word = 0; word < level.first.size(); ++word) {
        if (count > std::numeric_limits<uint32_t>::max()) {
            throw std::length_error("the scene has more than 4,294,967,295 exposed faces");
        }
        level.first[word] = static_cast<uint32_t>(count);
        count += static_cast<uint64_t>(std::popcount(level.word(8 * word)));
    }
    level.values.resize(count);
}

void add_region(std::vector<RegionLight>& regions, const RegionLight& added) {
    const auto same = std::find_if(regions.begin(), regions.end(),
                                   [&](const RegionLight& r) { return r.region == added.region; });
    if (same == regions.end()) {
        regions.push_back(added);
    } else {
        same->faces = static_cast<uint8_t>(same->faces | added.faces);
        same->brightest = std::max(same->brightest, added.brightest);
    }
}

/// Whether a region lies before a side of a node.
bool lies_before(const AirRegions& air, int region, const IVec3& corner, int edge, int face) {
    const int axis = face / 2;
    IVec3 at = corner;
    at[axis] += face % 2 == 0 ? edge : -1;
    for (int j = 0; j < edge; ++j) {
        for (int i = 0; i < edge; ++i) {
            at[(axis + 1) % 3] = corner[(axis + 1) % 3] + i;
            at[(axis + 2) % 3] = corner[(axis + 2) % 3] + j;
            if (air.of(at) == region) return true;
        }
    }
    return false;
}

}  // namespace

void FaceSums::add(const FaceSums& other) {
    for (size_t f = 0; f < kFaceCount; ++f) groups[f].add(other.groups[f]);
    for (const RegionLight& region : other.regions) add_region(regions, region);
    dimmest = std::min(dimmest, other.dimmest);
}

void FaceSums::leave_block() {
    if (regions.empty()) {
        for (const Group& group : groups) {
            if (group.count > 0) add_region(regions, {0, 0, group.brightest});
        }
    }
    for (const RegionLight& region : regions) dimmest = std::min(dimmest, region.brightest);
    regions.clear();
}

uint8_t divided_faces(const FaceSums& sums, const IVec3& corner, int edge, const AirRegions* air) {
    unsigned divided = 0;
    for (int face = 0; face < kFaceCount; ++face) {
        const float much_darker = kDividedRatio * sums.groups[static_cast<size_t>(face)].brightest;
        bool misleads = sums.dimmest < much_darker;
        for (const RegionLight& region : sums.regions) {
            if (!(region.brightest < much_darker)) continue;
            misleads = misleads || ((region.faces >> face) & 1u) != 0 ||
                       lies_before(*air, region.region, corner, edge, face);
        }
        if (misleads) divided |= 1u << face;
    }
    return static_cast<uint8_t>(divided);
}

FaceSums voxel_faces(const IVec3& position, uint8_t exposed,
                     const std::array<Rgb, kFaceCount>& radiance,
                     const std::array<int, kFaceCount>* region) {
    FaceSums sums;
    for (int face = 0; face < kFaceCount; ++face) {
        if (((exposed >> face) & 1u) == 0) continue;
        const Rgb& color = radiance[static_cast<size_t>(face)];
        const int plane = position[face / 2] + (face % 2 == 0 ? 1 : 0);
        sums.groups[static_cast<size_t>(face)] = {.sum = Vec3(color),
                                                  .count = 1,
                                                  .lit = color == Rgb(0.0f) ? 0u : 1u,
                                                  .darkest = luminance(color),
                                                  .brightest = luminance(color),
                                                  .low = plane,
                                                  .high = plane};
        if (region == nullptr) continue;
        add_region(sums.regions, {(*region)[static_cast<size_t>(face)],
                                  static_cast<uint8_t>(1u << face), luminance(color)});
    }
    return sums;
}

void lay_out(const VoxelTree& tree, FaceColors& colors) {
    colors.octants.exposed.resize(tree.octant_count());
    colors.nodes.exposed.resize(tree.nodes().size());
    for (int k = 0; k < tree.node_levels(); ++k) {
        const std::vector<uint8_t>& below = k == 0 ? colors.voxels.exposed : colors.nodes.exposed;
        const std::span<const VoxelNode> level = tree.node_level(k);
        const uint64_t begin = tree.level_begin(k);
        tbb::parallel_for(size_t{0}, level.size(), [&](size_t i) {
            uint32_t child = level[i].first_child;
            uint32_t octant = level[i].octant_base;
            unsigned all = 0;
            for (uint64_t rest = level[i].mask; rest != 0; rest >>= 8) {
                const int children = std::popcount(rest & 0xFFu);
                if (children == 0) continue;
                unsigned some = 0;
                for (int c = 0; c < children; ++c) some |= below[child++];
                colors.octants.exposed[octant++] = static_cast<uint8_t>(some);
                all |= some;
            }
            colors.nodes.exposed[begin + i] = static_cast<uint8_t>(all);
        });
    }
    index_values(colors.voxels);
    index_values(colors.octants);
    index_values(colors.nodes);
    colors.octants.divided.resize(tree.octant_count());
    colors.nodes.divided.resize(tree.nodes().size());
    colors.octants.groups.resize(colors.octants.values.size());
    colors.nodes.groups.resize(colors.nodes.values.size());
}

void write_means(FaceLevel& level, size_t node, const FaceSums& sums, const IVec3& corner, int edge,
                 float scale) {
    for (int face = 0; face < kFaceCount; ++face) {
        if (!level.exposes(node, face)) continue;
        const FaceSums::Group& group = sums.groups[static_cast<size_t>(face)];
        const size_t at = level.index_of(node, face);
        if (group.lit > 0) {
            level.values[at] =
                pack_rgb(Rgb(group.sum / (static_cast<double>(group.lit) * double{scale})));
        }
        if (level.groups.empty()) continue;
        const float stored = luminance(unpack_rgb(level.values[at])) * scale;
        const double darkest =
            stored > 0.0f ? std::min(1.0, double{group.darkest} / double{stored}) : 0.0;
        const double share = static_cast<double>(group.lit) / static_cast<double>(group.count);
        const double step = static_cast<double>(edge) / FaceGroup::kSteps;
        const int from = corner[face / 2];
        level.groups[at] = {
            .low = static_cast<uint8_t>(std::floor((group.low - from) / step)),
            .high = static_cast<uint8_t>(std::ceil((group.high - from) / step)),
            .share = static_cast<uint8_t>(
                group.lit == 0 ? 0.0 : std::max(1.0, std::round(share * FaceGroup::kAll))),
            .darkest = static_cast<uint8_t>(std::floor(darkest * FaceGroup::kAll))};
    }
}

}  // namespace probebake
