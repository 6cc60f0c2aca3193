#include "light/face_colors.h"

#include <cmath>
#include <limits>

namespace probebake {
namespace {

/// By how much a ray begins before the node that it goes on from, voxels: rounding must not put it
/// behind the node's own face.
constexpr double kBackwards = 1e-6;

class UndividedRule : public StopRule {
  public:
    UndividedRule(const FaceColors& colors, const VoxelTree& tree) : colors_(colors), tree_(tree) {}
    bool stops(const Hit& node) override { return !colors_.divided(tree_, node, node.level); }

  private:
    const FaceColors& colors_;
    const VoxelTree& tree_;
};

enum class Side { kBehind, kInFront, kBoth };

/// On which side of a group's faces the point lies; `at` in steps from the node's lowest corner.
Side side_of(const FaceGroup& group, bool towards_negative, double at) {
    if (towards_negative) {
        if (at <= group.low) return Side::kInFront;
        return at > group.high ? Side::kBehind : Side::kBoth;
    }
    if (at >= group.high) return Side::kInFront;
    return at < group.low ? Side::kBehind : Side::kBoth;
}

/// The stand-in for a face direction that the node does not expose (FaceColors::seen), without
/// the scale.
Rgb darkest_in_front(const FaceLevel& faces, size_t node, const Hit& hit) {
    const double step = std::ldexp(1.0, hit.level) / FaceGroup::kSteps;
    Rgb darkest(0.0f);
    float least = std::numeric_limits<float>::infinity();
    for (int face = 0; face < kFaceCount; ++face) {
        const int axis = face / 2;
        if (axis == axis_of(hit.entry_face) || !faces.exposes(node, face)) continue;
        const size_t at = faces.index_of(node, face);
        const Side side =
            side_of(faces.groups[at], face % 2 == 1, (hit.point[axis] - hit.corner[axis]) / step);
        if (side == Side::kBehind) continue;
        if (side == Side::kBoth) return Rgb(0.0f);
        const float share = static_cast<float>(faces.groups[at].darkest) / FaceGroup::kAll;
        const Rgb color = unpack_rgb(faces.values[at]) * share;
        if (luminance(color) < least) {
            least = luminance(color);
            darkest = color;
        }
    }
    return darkest;
}

}  // namespace

Rgb FaceColors::seen(const VoxelTree& tree, const Vec3& direction, const Hit& hit, int level,
                     uint32_t& steps) const {
    if (divided(tree, hit, hit.level)) {
        UndividedRule rule(*this, tree);
        const Hit finer = trace(tree, {hit.point, direction}, {.fixed_level = hit.level - 1},
                                {.t_min = -kBackwards}, rule);
        steps += finer.steps;
        return finer ? value_of(tree, finer, finer.level) : value_of(tree, hit, hit.level);
    }
    while (level > hit.level && divided(tree, hit, level)) --level;
    return value_of(tree, hit, level);
}

Rgb FaceColors::value_of(const VoxelTree& tree, const Hit& hit, int level) const {
    const ColorIndex own = color_index(tree, hit, hit.level);
    const int face = probebake::index_of(hit.entry_face);
    if (!this->level(own.array).exposes(own.index, face)) {
        if (own.array == ColorIndex::Array::kVoxels) return Rgb(0.0f);
        return darkest_in_front(this->level(own.array), own.index, hit) * scale;
    }
    const ColorIndex node = color_index(tree, hit, level);
    const FaceLevel& faces = this->level(node.array);
    const size_t at = faces.index_of(node.index, face);
    const float share =
        faces.groups.empty() ? 1.0f : static_cast<float>(faces.groups[at].share) / FaceGroup::kAll;
    return unpack_rgb(faces.values[at]) * (scale * share);
}

}  // namespace probebake
