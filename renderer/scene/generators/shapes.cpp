#include <algorithm>
#include <cmath>

#include "scene/generators/canvas.h"
#include "scene/generators/studies.h"

namespace probebake::worldgen {
namespace {

Canvas shape_canvas(int size, uint64_t seed) {
    return {size, kStudyVoxel_m, nullptr, random_key({seed, 71})};
}

/// A colour that tells positions apart: each channel rises along one axis.
Paint position_paint(const IVec3& v, int size) {
    const Vec3 share = (Vec3(v) + 0.5) / static_cast<double>(size);
    return {Rgb(0.15 + 0.6 * share), 0.1};
}

/// The voxels of a solid that have an empty neighbour, for a solid given as one span of y, [−half,
/// half] around the middle, per column: half(x, z), < 0 for none.
template <class HalfHeight>
void draw_shell(Canvas& canvas, HalfHeight half) {
    const int size = canvas.size();
    const int middle = size / 2;
    for (int z = 0; z < size; ++z) {
        for (int x = 0; x < size; ++x) {
            const int top = half(x, z);
            if (top < 0) continue;
            const int lowest =
                std::min({half(x - 1, z), half(x + 1, z), half(x, z - 1), half(x, z + 1), top - 1});
            for (int y = std::max(0, lowest + 1); y <= top; ++y) {
                for (const int at : {middle + y, middle - 1 - y}) {
                    canvas.put({x, at, z}, position_paint({x, at, z}, size));
                }
            }
        }
    }
}

}  // namespace

VoxelCloud make_sphere(int size, uint64_t seed) {
    Canvas canvas = shape_canvas(size, seed);
    const double radius = 0.375 * size;
    draw_shell(canvas, [&](int x, int z) {
        const double dx = x + 0.5 - 0.5 * size;
        const double dz = z + 0.5 - 0.5 * size;
        const double squared = radius * radius - dx * dx - dz * dz;
        return squared < 0.25 ? -1 : static_cast<int>(std::floor(std::sqrt(squared) - 0.5));
    });
    return canvas.take_cloud();
}

VoxelCloud make_box(int size, uint64_t seed) {
    Canvas canvas = shape_canvas(size, seed);
    draw_shell(canvas, [&](int x, int z) {
        const bool inside = std::min(x, z) >= size / 4 && std::max(x, z) < 3 * size / 4;
        return inside ? size / 4 - 1 : -1;
    });
    return canvas.take_cloud();
}

VoxelCloud make_plane(int size, uint64_t seed) {
    Canvas canvas = shape_canvas(size, seed);
    for (int z = 0; z < size; ++z) {
        for (int x = 0; x < size; ++x) {
            const IVec3 v(x, size / 4, z);
            canvas.put(v, position_paint(v, size));
        }
    }
    return canvas.take_cloud();
}

VoxelCloud make_stairs(int size, uint64_t seed) {
    Canvas canvas = shape_canvas(size, seed);
    constexpr int kSteps = 16;
    const auto tread = [&](int x) { return (x * kSteps / size + 1) * size / (2 * kSteps) - 1; };
    for (int z = 0; z < size; ++z) {
        for (int x = 0; x < size; ++x) {
            const int below = x == 0 ? -1 : tread(x - 1);
            for (int y = std::min(below + 1, tread(x)); y <= tread(x); ++y) {
                canvas.put({x, y, z}, position_paint({x, y, z}, size));
            }
        }
    }
    return canvas.take_cloud();
}

VoxelCloud make_single(int size, uint64_t seed) {
    Canvas canvas = shape_canvas(size, seed);
    canvas.put(IVec3(size / 2), {Rgb(0.5f), 0.0});
    return canvas.take_cloud();
}

}  // namespace probebake::worldgen
