#include "scene/generators/cornell.h"

#include "scene/generators/canvas.h"
#include "scene/generators/studies.h"

namespace probebake::worldgen {
namespace {

constexpr Rgb kWhite{0.725f, 0.71f, 0.68f};
constexpr Rgb kRed{0.63f, 0.065f, 0.05f};
constexpr Rgb kGreen{0.14f, 0.45f, 0.091f};

Paint flat(const Rgb& color, const Rgb& emission = Rgb(0.0f)) {
    return {color, 0.0, Layer::kBuilding, emission};
}

Paint wall_paint(const IVec3& v) {
    if (v.x == cornell::kBoxMin.x) return flat(kRed);
    if (v.x == cornell::kBoxMax.x - 1) return flat(kGreen);
    return flat(kWhite);
}

}  // namespace

VoxelCloud make_cornell(int size, uint64_t seed) {
    using namespace cornell;
    Canvas canvas(size, kStudyVoxel_m, nullptr, seed);
    for (int z = 0; z < size; ++z) {
        for (int x = 0; x < size; ++x) canvas.put({x, kFloorY, z}, flat(kFloorAlbedo));
    }
    for (int z = kBoxMin.z; z < kBoxMax.z; ++z) {
        for (int y = kBoxMin.y; y < kBoxMax.y; ++y) {
            for (int x = kBoxMin.x; x < kBoxMax.x; ++x) {
                const bool side = x == kBoxMin.x || x == kBoxMax.x - 1 || y == kBoxMin.y ||
                                  y == kBoxMax.y - 1 || z == kBoxMin.z;
                const bool bar = z == kGratingZ && x % 2 == 0;
                if (side || bar) canvas.put({x, y, z}, wall_paint({x, y, z}));
            }
        }
    }
    for (int y = kLightMin.y; y < kLightMax.y; ++y) {
        for (int x = kLightMin.x; x < kLightMax.x; ++x) {
            canvas.put({x, y, kLightMin.z}, flat(kWhite, kLightRadiance));
        }
    }
    return canvas.take_cloud();
}

}  // namespace probebake::worldgen
