// Density grids to test with.
#pragma once

#include <gtest/gtest.h>

#include "math/random.h"
#include "volume/density_grid.h"

namespace probebake::test {

/// A grid whose lattice value at p is value(p) inside and 0 on the border of its box.
template <class Value>
DensityGrid make_grid(const IVec3& low, const IVec3& cells, Value value) {
    return DensityGrid({low, cells}, [&](const IVec3& from, DensityGrid::BrickValues values) {
        size_t i = 0;
        for (int z = 0; z < DensityGrid::kSide; ++z) {
            for (int y = 0; y < DensityGrid::kSide; ++y) {
                for (int x = 0; x < DensityGrid::kSide; ++x) {
                    const IVec3 p = from + IVec3(x, y, z);
                    const bool inside = glm::all(glm::greaterThan(p, low)) &&
                                        glm::all(glm::lessThan(p, low + cells));
                    values[i++] = inside ? value(p) : 0.0f;
                }
            }
        }
        return true;
    });
}

/// Noise in blobs, a part of it empty: value of a hash, 0 where a coarser hash is small.
inline float noise_value(const IVec3& p, uint64_t seed) {
    const auto hash = [&](const IVec3& q) {
        return RandomStream(random_key({seed, static_cast<uint64_t>(q.x + 1000),
                                        static_cast<uint64_t>(q.y + 1000),
                                        static_cast<uint64_t>(q.z + 1000)}))
            .uniform();
    };
    return hash(p / 4) < 0.4 ? 0.0f : static_cast<float>(hash(p));
}

inline DensityGrid noise_grid(const IVec3& low, const IVec3& cells, uint64_t seed) {
    return make_grid(low, cells, [=](const IVec3& p) { return noise_value(p, seed); });
}

}  // namespace probebake::test
