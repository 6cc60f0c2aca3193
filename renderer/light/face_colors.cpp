#include "light/face_colors.h"

#include <algorithm>

namespace probebake {
namespace {

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
Rgb darkest_in_front(const FaceLevel& faces, size_t node, const Hit& hit, int level) {
    const double step = std::ldexp(1.0, level) / FaceGroup::kSteps;
    Rgb darkest(0.0f);
    float least = std::numeric_limits<float>::infinity();
    for (int face = 0; face < kFaceCount; ++face) {
        const int axis = face / 2;
        if (axis == axis_of(hit.entry_face) || !faces.exposes(node, face)) continue;
        const size_t at = faces.index_of(node, face);
        const int corner = (hit.corner[axis] >> level) << level;
        const Side side =
            side_of(faces.groups[at], face % 2 == 1, (hit.point[axis] - corner) / step);
        if (side == Side::kBehind) continue;
        if (side == Side::kBoth) return Rgb(0.0f);
        const float share = static_cast<float>(faces.groups[at].darkest) / FaceGroup::kFull;
        const Rgb color = unpack_rgb(faces.values[at]) * share;
        if (luminance(color) < least) {
            least = luminance(color);
            darkest = color;
        }
    }
    return darkest;
}

}  // namespace

bool FaceLevel::operator==(const FaceLevel& other) const {
    return exposed == other.exposed && first == other.first && values == other.values &&
           std::equal(groups.begin(), groups.end(), other.groups.begin(), other.groups.end(),
                      [](const FaceGroup& a, const FaceGroup& b) {
                          return a.low == b.low && a.high == b.high && a.darkest == b.darkest;
                      });
}

Rgb FaceColors::seen(const VoxelTree& tree, const Hit& hit, int level) const {
    const ColorIndex node = color_index(tree, hit, level);
    const FaceLevel& faces = this->level(node.array);
    const int face = probebake::index_of(hit.entry_face);
    if (faces.exposes(node.index, face)) {
        return unpack_rgb(faces.values[faces.index_of(node.index, face)]) * scale;
    }
    if (node.array == ColorIndex::Array::kVoxels) return Rgb(0.0f);
    return darkest_in_front(faces, node.index, hit, level) * scale;
}

}  // namespace probebake
