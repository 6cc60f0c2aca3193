#include "image/octahedral.h"

#include <cmath>

namespace probebake {
namespace {

/// The lower half of the octahedron is folded outwards over the edges of the upper one.
Vec2 folded(const Vec2& p) {
    return {std::copysign(1.0 - std::abs(p.y), p.x), std::copysign(1.0 - std::abs(p.x), p.y)};
}

}  // namespace

Vec3 octahedral_direction(double x, double y) {
    const double z = 1.0 - std::abs(x) - std::abs(y);
    const Vec2 at = z < 0.0 ? folded({x, y}) : Vec2(x, y);
    return glm::normalize(Vec3(at, z));
}

Vec2 octahedral_point(const Vec3& d) {
    const Vec2 at = Vec2(d) / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
    return d.z < 0.0 ? folded(at) : at;
}

Vec3 octahedral_texel_direction(int x, int y, int inside_px) {
    return octahedral_direction((2.0 * x + 1.0) / inside_px - 1.0,
                                (2.0 * y + 1.0) / inside_px - 1.0);
}

void fill_octahedral_border(Image& image, int left, int top, int inside_px) {
    const int end = inside_px + 1;
    const auto copy = [&](int x, int y, int from_x, int from_y) {
        image.at(left + x, top + y) = image.at(left + from_x, top + from_y);
    };
    for (int i = 1; i < end; ++i) {
        copy(i, 0, end - i, 1);
        copy(i, end, end - i, inside_px);
        copy(0, i, 1, end - i);
        copy(end, i, inside_px, end - i);
    }
    copy(0, 0, inside_px, inside_px);
    copy(end, 0, 1, inside_px);
    copy(0, end, inside_px, 1);
    copy(end, end, 1, 1);
}

}  // namespace probebake
