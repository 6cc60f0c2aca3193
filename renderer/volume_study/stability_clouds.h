// Small clouds of the stability study.
#pragma once

#include "math/random.h"
#include "volume/media.h"

namespace probebake::volume_study {

/// A lattice of `cells` cells whose values are density(lattice point).
template <class Density>
std::shared_ptr<DensityGrid> lattice(int cells, Density density) {
    return std::make_shared<DensityGrid>(
        DensityGrid::BuildParams{IVec3(0), IVec3(cells)},
        [&](const IVec3& low, DensityGrid::BrickValues values) {
            size_t i = 0;
            for (int z = 0; z < DensityGrid::kSide; ++z) {
                for (int y = 0; y < DensityGrid::kSide; ++y) {
                    for (int x = 0; x < DensityGrid::kSide; ++x) {
                        const IVec3 p = low + IVec3(x, y, z);
                        const bool border = glm::any(glm::lessThanEqual(p, IVec3(0))) ||
                                            glm::any(glm::greaterThanEqual(p, IVec3(cells)));
                        values[i++] = border ? 0.0f : density(p);
                    }
                }
            }
            return true;
        });
}

/// A lumpy ball of 24 cells.
inline GridShape lumps(const Vec3& middle_m = Vec3(0.0), double cell_m = 0.5) {
    GridShape shape{.density = lattice(24, [](const IVec3& p) {
                        const double r = glm::length(Vec3(p) - 12.0) / 12.0;
                        RandomStream random(
                            random_key({static_cast<uint64_t>(p.x), static_cast<uint64_t>(p.y),
                                        static_cast<uint64_t>(p.z)}));
                        return static_cast<float>(std::max(0.0, 1.0 - r) * 2.0 * random.uniform());
                    })};
    shape.index_to_world.linear = glm::dmat3(cell_m);
    shape.index_to_world.offset = middle_m - Vec3(12.0 * cell_m);
    return shape;
}

}  // namespace probebake::volume_study
