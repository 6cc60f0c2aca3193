#include "scatter/emitter_sampler.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace probebake {
namespace {

IVec3 beside(IVec3 voxel, int face) {
    voxel[face / 2] += face % 2 == 0 ? 1 : -1;
    return voxel;
}

uint8_t exposed_faces(const VoxelTree& tree, const IVec3& voxel) {
    uint32_t faces = 0;
    for (int f = 0; f < kFaceCount; ++f) {
        if (!tree.occupied(beside(voxel, f))) faces |= 1u << f;
    }
    return static_cast<uint8_t>(faces);
}

/// How high above the face's plane a point is, of the box from `low` to `high`; below 0 behind it.
double height_above(const Vec3& from, int face, double low, double high) {
    return face % 2 == 0 ? from[face / 2] - high : low - from[face / 2];
}

}  // namespace

EmitterSampler::EmitterSampler(const VoxelTree& tree) {
    const ColorLevels& emission = tree.colors().emission;
    if (emission.empty()) return;
    std::vector<Node> emitters;
    uint32_t index = 0;
    tree.for_each_voxel([&](const IVec3& voxel) {
        const uint32_t at = index++;
        const Rgb radiance = emission[{ColorIndex::Array::kVoxels, at}];
        const float sum = radiance.r + radiance.g + radiance.b;
        if (!(sum > 0.0f)) return;
        const uint8_t faces = exposed_faces(tree, voxel);
        if (faces == 0) return;
        largest_radiance_ =
            std::max(largest_radiance_, glm::length(Vec3(radiance)) / std::sqrt(3.0));
        if (++found_ > kMostEmitters) return;
        Node node;
        node.power = sum / 3.0f * static_cast<float>(std::popcount(faces));
        node.faces = faces;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<size_t>(axis);
            node.low[a] = node.high[a] = static_cast<uint16_t>(voxel[axis]);
        }
        emitters.push_back(node);
        voxels_.push_back(at);
    });
    if (found_ > kMostEmitters) voxels_.clear();
    if (voxels_.empty()) return;
    levels_.push_back(std::move(emitters));
    while (levels_.back().size() > 1) {
        const std::vector<Node>& below = levels_.back();
        std::vector<Node> level((below.size() + 1) / 2);
        for (size_t i = 0; i < level.size(); ++i) {
            level[i] = below[2 * i];
            if (2 * i + 1 < below.size()) level[i] += below[2 * i + 1];
        }
        levels_.push_back(std::move(level));
    }
}

EmitterSampler::Node& EmitterSampler::Node::operator+=(const Node& other) {
    power += other.power;
    faces = static_cast<uint8_t>(faces | other.faces);
    for (size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], other.low[axis]);
        high[axis] = std::max(high[axis], other.high[axis]);
    }
    return *this;
}

double EmitterSampler::Node::importance(const Vec3& from) const {
    bool seen = false;
    double distance2 = 0.0;
    double radius2 = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double lowest = low[static_cast<size_t>(axis)];
        const double highest = high[static_cast<size_t>(axis)];
        // The lowest plane that a face looking up may have, the highest of one looking down.
        seen |= ((faces >> (2 * axis)) & 1) != 0 && from[axis] > lowest + 1.0;
        seen |= ((faces >> (2 * axis + 1)) & 1) != 0 && from[axis] < highest;
        const double half = 0.5 * (highest + 1.0 - lowest);
        const double off = from[axis] - lowest - half;
        distance2 += off * off;
        radius2 += half * half;
    }
    return seen ? double{power} / std::max(distance2, radius2) : 0.0;
}

double EmitterSampler::left_share(size_t level, size_t left, const Vec3& from) const {
    const std::vector<Node>& nodes = levels_[level];
    if (left + 1 == nodes.size()) return 1.0;
    const double a = nodes[left].importance(from);
    const double b = nodes[left + 1].importance(from);
    return a + b > 0.0 ? a / (a + b) : -1.0;
}

std::optional<EmitterSampler::Sample> EmitterSampler::sample(const Vec3& from,
                                                             const std::array<double, 3>& u) const {
    if (empty()) return std::nullopt;
    Sample out{.probability = 1.0};
    double v = u[0];
    size_t i = 0;
    for (size_t level = levels_.size() - 1; level-- > 0;) {
        i *= 2;
        const double left = left_share(level, i, from);
        if (left < 0.0) return std::nullopt;
        const bool right = !(v < left);
        const double share = right ? 1.0 - left : left;
        v = std::clamp((right ? v - left : v) / share, 0.0, 1.0 - 0x1.0p-53);
        out.probability *= share;
        if (right) ++i;
    }
    const Node& voxel = levels_[0][i];
    std::array<double, kFaceCount> heights{};
    double sum = 0.0;
    int chosen = -1;
    for (int f = 0; f < kFaceCount; ++f) {
        const auto axis = static_cast<size_t>(f / 2);
        if (((voxel.faces >> f) & 1) == 0) continue;
        const double h = height_above(from, f, voxel.low[axis], voxel.low[axis] + 1.0);
        heights[static_cast<size_t>(f)] = std::max(0.0, h);
        sum += heights[static_cast<size_t>(f)];
    }
    if (!(sum > 0.0)) return std::nullopt;
    v *= sum;
    for (int f = 0; f < kFaceCount; ++f) {
        const double h = heights[static_cast<size_t>(f)];
        if (!(h > 0.0)) continue;
        chosen = f;
        if (v < h) break;
        v -= h;
    }
    out.probability *= heights[static_cast<size_t>(chosen)] / sum;
    out.face = kCubeFaces[static_cast<size_t>(chosen)];
    const int axis = chosen / 2;
    out.corner = {voxel.low[0], voxel.low[1], voxel.low[2]};
    out.point = Vec3(out.corner);
    out.point[axis] += chosen % 2 == 0 ? 1.0 : 0.0;
    out.point[(axis + 1) % 3] += u[1];
    out.point[(axis + 2) % 3] += u[2];
    return out;
}

double EmitterSampler::probability(const Vec3& from, uint32_t voxel, CubeFace face) const {
    const auto at = std::lower_bound(voxels_.begin(), voxels_.end(), voxel);
    if (at == voxels_.end() || *at != voxel) return 0.0;
    const auto emitter = static_cast<size_t>(at - voxels_.begin());
    double probability = 1.0;
    for (size_t level = levels_.size() - 1; level-- > 0;) {
        const size_t i = emitter >> level;
        const double left = left_share(level, i & ~size_t{1}, from);
        if (left < 0.0) return 0.0;
        probability *= (i & 1) == 0 ? left : 1.0 - left;
    }
    const Node& node = levels_[0][emitter];
    double sum = 0.0;
    double own = 0.0;
    for (int f = 0; f < kFaceCount; ++f) {
        const auto axis = static_cast<size_t>(f / 2);
        if (((node.faces >> f) & 1) == 0) continue;
        const double h = std::max(0.0, height_above(from, f, node.low[axis], node.low[axis] + 1.0));
        sum += h;
        if (f == index_of(face)) own = h;
    }
    return sum > 0.0 ? probability * own / sum : 0.0;
}

uint64_t EmitterSampler::memory_bytes() const {
    uint64_t bytes = voxels_.size() * sizeof(uint32_t);
    for (const auto& level : levels_) bytes += level.size() * sizeof(Node);
    return bytes;
}

}  // namespace probebake
