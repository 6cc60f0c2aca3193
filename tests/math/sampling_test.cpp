#include "math/sampling.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <set>

#include "math/random.h"

namespace probebake {
namespace {

TEST(Random, StreamsAreUniform) {
    RandomStream random(random_key({1, 2, 3}));
    constexpr int kBins = 64;
    constexpr int kDraws = 640'000;
    std::array<int, kBins> bins{};
    for (int i = 0; i < kDraws; ++i) ++bins[static_cast<size_t>(random.uniform() * kBins)];
    double chi2 = 0.0;
    constexpr double kExpected = static_cast<double>(kDraws) / kBins;
    for (const int count : bins) chi2 += (count - kExpected) * (count - kExpected) / kExpected;
    EXPECT_LT(chi2, 125.0);  // 63 degrees of freedom: exceeded once in 10^5
    EXPECT_GT(chi2, 25.0);   // nor suspiciously even
}

TEST(Random, KeysThatDifferInOnePartGiveUnrelatedStreams) {
    std::set<uint64_t> firsts;
    for (uint64_t a = 0; a < 32; ++a) {
        for (uint64_t b = 0; b < 32; ++b) {
            for (uint64_t c = 0; c < 32; ++c) {
                firsts.insert(RandomStream(random_key({a, b, c})).next());
            }
        }
    }
    EXPECT_EQ(firsts.size(), 32u * 32u * 32u);
    // Neighbouring keys: bits of the first numbers agree half of the time.
    int differing = 0;
    for (uint64_t a = 0; a < 1000; ++a) {
        differing += std::popcount(RandomStream(random_key({a})).next() ^
                                   RandomStream(random_key({a + 1})).next());
    }
    EXPECT_NEAR(differing / 64000.0, 0.5, 0.01);
}

TEST(Sampling, CorrelatedMultiJitterFillsCellsAndStrips) {
    constexpr uint32_t kColumns = 16;
    constexpr uint32_t kRows = 8;
    constexpr uint32_t kCount = kColumns * kRows;
    for (const uint32_t pattern : {1u, 2u, 99u}) {
        std::set<std::pair<int, int>> cells;
        std::set<int> columns;
        std::set<int> rows;
        for (uint32_t i = 0; i < kCount; ++i) {
            const Vec2 p = correlated_multi_jitter(i, kColumns, kRows, pattern);
            ASSERT_GE(p.x, 0.0);
            ASSERT_LT(p.x, 1.0);
            ASSERT_GE(p.y, 0.0);
            ASSERT_LT(p.y, 1.0);
            cells.insert({static_cast<int>(p.x * kColumns), static_cast<int>(p.y * kRows)});
            columns.insert(static_cast<int>(p.x * kCount));
            rows.insert(static_cast<int>(p.y * kCount));
        }
        EXPECT_EQ(cells.size(), kCount);
        EXPECT_EQ(columns.size(), kCount);
        EXPECT_EQ(rows.size(), kCount);
    }
}

TEST(Sampling, OwenSobolGrowsFromGridToGrid) {
    std::array<double, 16> place{};
    for (uint64_t run = 0; run < 64; ++run) {
        const uint64_t key = random_key({3, run});
        for (int side = 1; side <= 32; side *= 2) {
            std::set<std::pair<int, int>> cells;
            std::set<int> columns;
            std::set<int> rows;
            const int count = side * side;
            for (int i = 0; i < count; ++i) {
                const Vec2 p = owen_sobol(static_cast<uint32_t>(i), key);
                ASSERT_GE(std::min(p.x, p.y), 0.0);
                ASSERT_LT(std::max(p.x, p.y), 1.0);
                cells.insert({static_cast<int>(p.x * side), static_cast<int>(p.y * side)});
                columns.insert(static_cast<int>(p.x * count));
                rows.insert(static_cast<int>(p.y * count));
            }
            ASSERT_EQ(cells.size(), static_cast<size_t>(count));
            ASSERT_EQ(columns.size(), static_cast<size_t>(count));
            ASSERT_EQ(rows.size(), static_cast<size_t>(count));
        }
    }
    // Every point is uniform over the keys: 4 × 4 cells, 15 degrees of freedom, for a few indices.
    constexpr int kKeys = 16'000;
    for (const uint32_t index : {0u, 1u, 5u, 63u, 200u}) {
        place.fill(0.0);
        for (int k = 0; k < kKeys; ++k) {
            const Vec2 p = owen_sobol(index, random_key({4, static_cast<uint64_t>(k)}));
            place[static_cast<size_t>(p.x * 4) * 4 + static_cast<size_t>(p.y * 4)] += 1.0;
        }
        double chi2 = 0.0;
        for (const double n : place) chi2 += (n - kKeys / 16.0) * (n - kKeys / 16.0) * 16.0 / kKeys;
        EXPECT_LT(chi2, 45.0) << index;  // exceeded once in 10^4
    }
}

TEST(Sampling, EveryDimensionOfOwenSobolIsStratified) {
    for (uint64_t run = 0; run < 16; ++run) {
        const uint64_t key = random_key({5, run});
        std::array<std::set<int>, 4> strata;
        for (uint32_t i = 0; i < 256; ++i) {
            const std::array<double, 4> p = owen_sobol_4d(i, key);
            for (size_t d = 0; d < 4; ++d) strata[d].insert(static_cast<int>(p[d] * 256.0));
            ASSERT_EQ(Vec2(p[0], p[1]), owen_sobol(i, key));
        }
        for (const std::set<int>& hit : strata) EXPECT_EQ(hit.size(), 256u);
    }
}

}  // namespace
}  // namespace probebake
