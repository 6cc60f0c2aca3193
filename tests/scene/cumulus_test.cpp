#include "scene/generators/cumulus.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <bit>

#include "math/random.h"

namespace probebake {
namespace {

uint64_t hash_of(const DensityGrid& grid, int size) {
    uint64_t hash = 0;
    for (int z = 0; z < size; ++z) {
        for (int y = 0; y < size; ++y) {
            for (int x = 0; x < size; ++x) {
                hash = mix64(hash ^ std::bit_cast<uint32_t>(grid.value({x, y, z})));
            }
        }
    }
    return hash;
}

TEST(Cumulus, IsTheSameOnEveryMachineAndForAnyNumberOfThreads) {
    constexpr int kSize = 64;
    const uint64_t parallel = hash_of(make_cumulus({.size = kSize}), kSize);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(hash_of(make_cumulus({.size = kSize}), kSize), parallel);
    EXPECT_EQ(parallel, 0x187B59EA6AC23128ull);
    EXPECT_NE(hash_of(make_cumulus({.size = kSize, .seed = 2}), kSize), parallel);
}

TEST(Cumulus, FillsItsBoxWithDensities) {
    constexpr int kSize = 96;
    const DensityGrid grid = make_cumulus({.size = kSize});
    EXPECT_TRUE(grid.is_half());
    int full = 0;
    for (int z = 0; z < kSize; ++z) {
        for (int y = 0; y < kSize; ++y) {
            for (int x = 0; x < kSize; ++x) {
                const float d = grid.value({x, y, z});
                EXPECT_LE(d, 1.0f);
                const bool border = std::min({x, y, z}) == 0 || std::max({x, y, z}) == kSize - 1;
                if (border) {
                    EXPECT_EQ(d, 0.0f);
                }
                full += d > 0.2f ? 1 : 0;
            }
        }
    }
    const double share = full / static_cast<double>(kSize * kSize * kSize);
    EXPECT_GT(share, 0.03);
    EXPECT_LT(share, 0.4);
    EXPECT_THROW(make_cumulus({.size = 8}), std::invalid_argument);
}

}  // namespace
}  // namespace probebake
