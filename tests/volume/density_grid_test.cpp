#include "volume/density_grid.h"

#include <cmath>
#include <limits>

#include "volume/volume_fixture.h"

namespace probebake {
namespace {

using test::make_grid;

TEST(DensityGrid, ALookUpAtALatticePointGivesItsValue) {
    const IVec3 low(-5, 3, -17);
    const IVec3 cells(20, 9, 33);
    const DensityGrid grid = test::noise_grid(low, cells, 1);
    for (int z = 0; z < cells.z; ++z) {
        for (int y = 0; y < cells.y; ++y) {
            for (int x = 0; x < cells.x; ++x) {
                const IVec3 p = low + IVec3(x, y, z);
                ASSERT_EQ(grid.sample(Vec3(p)), double{grid.value(p)});
                if (x > 0 && y > 0 && z > 0) {
                    ASSERT_EQ(grid.value(p), test::noise_value(p, 1));
                }
            }
        }
    }
}

TEST(DensityGrid, InBetweenIsTrilinear) {
    // A product of linear functions is reproduced.
    const auto value = [](const IVec3& p) {
        return static_cast<float>((p.x + 1) * (2 * p.y + 3) * (p.z + 5));
    };
    const DensityGrid grid = make_grid({0, 0, 0}, {19, 18, 17}, value);
    RandomStream random(2);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 p =
            Vec3(1.0) +
            Vec3(random.uniform() * 17.0, random.uniform() * 16.0, random.uniform() * 15.0) * 0.999;
        const double exact = (p.x + 1) * (2 * p.y + 3) * (p.z + 5);
        EXPECT_NEAR(grid.sample(p), exact, 1e-9 * exact);
    }
}

TEST(DensityGrid, OutsideIsNothing) {
    const DensityGrid grid = make_grid({0, 0, 0}, {8, 8, 8}, [](const IVec3&) { return 1.0f; });
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (const Vec3 p : {Vec3(-0.1, 4, 4), Vec3(4, 8.1, 4), Vec3(4, 4, 1e30), Vec3(4, kNan, 4)}) {
        EXPECT_EQ(grid.sample(p), 0.0);
    }
    EXPECT_EQ(grid.value({-1, 0, 0}), 0.0f);
    EXPECT_EQ(grid.value({0, 0, 9}), 0.0f);
}

TEST(DensityGrid, HalvesAreKeptAsHalvesWhereNothingIsLost) {
    const auto halves = make_grid({0, 0, 0}, {24, 8, 8}, [](const IVec3& p) {
        return static_cast<float>(p.x) * 0.125f + 0x1.0p-24f * static_cast<float>(p.y);
    });
    EXPECT_FALSE(halves.is_half());  // 11 bits between the smallest and the largest do not suffice
    const auto exact = make_grid({0, 0, 0}, {24, 8, 8}, [](const IVec3& p) {
        return p.y == 4 ? 0x1.0p-24f : static_cast<float>(p.x) * 0.125f;
    });
    EXPECT_TRUE(exact.is_half());
    EXPECT_EQ(exact.value({3, 4, 2}), 0x1.0p-24f);  // a subnormal half
    EXPECT_EQ(exact.value({23, 5, 2}), 2.875f);
    EXPECT_FALSE(make_grid({0, 0, 0}, {8, 8, 8}, [](const IVec3&) { return 65536.0f; }).is_half());
}

TEST(DensityGrid, ConstantBricksTakeNoRoom) {
    const DensityGrid grid({IVec3(0), IVec3(64)}, [](const IVec3& low, DensityGrid::BrickValues v) {
        for (float& x : v) x = low.x < 32 ? 0.25f : 0.0f;
        return low.y < 32;
    });
    EXPECT_EQ(grid.stored_bricks(), 0u);
    EXPECT_EQ(grid.sample({3.5, 7.5, 11.5}), 0.25);
    EXPECT_EQ(grid.sample({3.5, 40.5, 11.5}), 0.0);
    EXPECT_EQ(grid.value({40, 3, 3}), 0.0f);
}

TEST(DensityGrid, WhatIsNoDensityIsCountedAndRefused) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInf = std::numeric_limits<float>::infinity();
    const auto value = [=](const IVec3& p) {
        if (p == IVec3(9, 10, 11)) return kNan;
        if (p == IVec3(8, 16, 20)) return -kInf;
        if (p == IVec3(20, 8, 16)) return -1e-30f;
        return 0.5f;
    };
    try {
        make_grid({0, 0, 0}, {30, 30, 30}, value);
        FAIL();
    } catch (const BadDensity& error) {
        EXPECT_EQ(error.not_finite(), 2u);
        EXPECT_EQ(error.negative(), 1u);
        EXPECT_EQ(error.first(), IVec3(9, 10, 11));
        EXPECT_STREQ(error.what(),
                     "2 voxels are NaN or infinite, 1 are negative, the first at "
                     "[9 10 11]; expected finite densities, not negative");
    }
}

TEST(DensityGrid, AbsurdExtentsAreRefused) {
    const auto nothing = [](const IVec3&, DensityGrid::BrickValues) { return false; };
    EXPECT_THROW(DensityGrid({IVec3(0), IVec3(0, 1, 1)}, nothing), std::length_error);
    EXPECT_THROW(DensityGrid({IVec3(0), IVec3(40000, 1, 1)}, nothing), std::length_error);
    EXPECT_THROW(DensityGrid({IVec3(0), IVec3(32768)}, nothing), std::length_error);
    EXPECT_NO_THROW(DensityGrid({IVec3(-2'000'000'000), IVec3(32768, 9, 9)}, nothing));
}

}  // namespace
}  // namespace probebake
