#include "track/transmittance.h"

#include <gtest/gtest.h>

#include "math/estimate.h"
#include "track/lattice_line.h"
#include "track/ray_march.h"

namespace probebake {
namespace {

using test::LatticeLine;
using test::LatticeMedium;

template <class Estimate>
std::array<Moments, 3> sample(const LatticeMedium& medium, int depth, uint64_t key, int n,
                              Estimate estimate, double planted = 1.0, double bound = 1.0) {
    std::array<Moments, 3> moments;
    RandomStream random(key);
    TrackCount count;
    for (int i = 0; i < n; ++i) {
        LatticeLine line(medium, depth, planted, bound);
        const Spectrum<3> t = estimate(line, random, count);
        for (int c = 0; c < 3; ++c) moments[static_cast<size_t>(c)].add(t[c]);
    }
    EXPECT_EQ(count.faults, 0u);
    return moments;
}

/// Largest |z| over media × 2 depths × channels, where the mean of n samples is nearly normal.
template <class Estimate>
double largest_z(uint64_t key, Estimate estimate, double planted,
                 const std::vector<int>& channels) {
    constexpr int kSamples = 10000;
    double most = 0.0;
    const std::vector<LatticeMedium> media = test::seventeen_media();
    for (size_t i = 0; i < media.size(); ++i) {
        const Spectrum<3> exact = test::solve(media[i]).escape;
        if (exact.min() < 0.01) continue;
        for (const int depth : {1, 5}) {
            const auto m =
                sample(media[i], depth, random_key({key, i}), kSamples, estimate, planted);
            for (const int c : channels) {
                const Moments& mc = m[static_cast<size_t>(c)];
                const double sigma = std::sqrt(mc.variance() / kSamples);
                const double off = std::abs(mc.mean() - exact[c]);
                if (off > 1e-9) most = std::max(most, sigma > 0.0 ? off / sigma : 1e9);
            }
        }
    }
    return most;
}

// A bias of 5 % of an optical depth of 1 is 1.8 % of T: some 4 standard errors of delta tracking,
// more of the others.
template <class Estimate>
void expect_unbiased(uint64_t key, Estimate estimate,
                     const std::vector<int>& channels = {0, 1, 2}) {
    EXPECT_LT(largest_z(key, estimate, 1.0, channels), 4.5);
    EXPECT_GT(largest_z(key, estimate, 1.05, channels), 4.5);
}

const auto kRatio = [](LatticeLine& line, RandomStream& random, TrackCount& count) {
    return RatioTracking<false>::transmittance<TrackTraits<3, true, false>>(line, random, count);
};
const auto kRoulette = [](LatticeLine& line, RandomStream& random, TrackCount& count) {
    return RatioTracking<true>::transmittance<TrackTraits<3, true, false>>(line, random, count);
};
const auto kResidual = [](LatticeLine& line, RandomStream& random, TrackCount& count) {
    return ResidualRatio::transmittance<TrackTraits<3, true, false>>(line, random, count);
};

TEST(Transmittance, RatioIsUnbiased) { expect_unbiased(1, kRatio); }
TEST(Transmittance, RatioWithRouletteIsUnbiased) { expect_unbiased(2, kRoulette); }
TEST(Transmittance, ResidualRatioIsUnbiased) { expect_unbiased(3, kResidual); }
TEST(Transmittance, DeltaIsUnbiased) {
    const auto delta = [](LatticeLine& line, RandomStream& random, TrackCount& count) {
        ChannelLine<LatticeLine> one(line, 1);
        return Spectrum<3>(
            DeltaVisibility::transmittance<TrackTraits<1, true, false>>(one, random, count)[0]);
    };
    expect_unbiased(4, delta, {1});
}

TEST(Transmittance, UnbiasedRayMarchingAgrees) {
    RandomStream random(5);
    for (const LatticeMedium& medium : test::seventeen_media()) {
        const Spectrum<3> exact = test::solve(medium).escape;
        if (exact.min() < 0.01) continue;
        Moments moments;
        for (int i = 0; i < 20000; ++i) {
            moments.add(marched_transmittance(
                [&](double t) { return medium.at(t).extinction()[2]; }, medium.length, 8, random));
        }
        const double sigma = std::sqrt(moments.variance() / 20000.0);
        EXPECT_NEAR(moments.mean(), exact[2], 4.5 * sigma + 1e-9) << medium.name;
    }
}

TEST(Transmittance, TheMinorantKeepsResidualRatioWithinBounds) {
    // A slab in vacuum: where the leaf is mostly empty, a control above the minorant must be undone
    // by factors above 1.
    const LatticeMedium medium = test::seventeen_media()[7];
    RandomStream random(6);
    TrackCount count;
    Moments minorant;
    Moments middle;
    const double exact = test::solve(medium).escape[1];
    for (int i = 0; i < 20000; ++i) {
        LatticeLine line(medium, 1);
        const Spectrum<3> t = kResidual(line, random, count);
        EXPECT_GE(t.min(), 0.0);
        EXPECT_LE(t.max(), 1.0);
        minorant.add((t[1] - exact) * (t[1] - exact));
        LatticeLine again(medium, 1);
        const Spectrum<3> m =
            ResidualRatio::transmittance<TrackTraits<3, true, false>>(again, random, count, 0.5);
        middle.add((m[1] - exact) * (m[1] - exact));
    }
    EXPECT_LT(5.0 * minorant.mean(), middle.mean());
}

// Relative variance of ratio tracking with b = f μ: e^(τ/f) − 1.
TEST(Transmittance, ANonBoundingMajorantHasTheVarianceOfTheClosedForm) {
    const LatticeMedium medium =
        test::make_medium({"gray", 1.0, [](double) { return 0.0; }, [](double) { return 1.0; }});
    for (const double f : {0.5, 0.8, 1.5}) {
        Moments squares;
        RandomStream random(random_key({7, static_cast<uint64_t>(10 * f)}));
        TrackCount count;
        for (int i = 0; i < 200000; ++i) {
            LatticeLine line(medium, 1, 1.0, f);
            const double t = kRatio(line, random, count)[0];
            squares.add(t * t);
        }
        const double expected = std::exp(1.0 / f) * std::exp(-2.0);
        EXPECT_NEAR(squares.mean(), expected, 4.5 * std::sqrt(squares.variance() / 200000.0)) << f;
    }
}

TEST(Transmittance, RouletteSparesLookUpsInThickMedia) {
    const LatticeMedium thick =
        test::make_medium({"thick", 1.0, [](double) { return 0.0; },
                           [](double x) { return x < 0.5 ? 1500.0 : 500.0; }});
    RandomStream random(8);
    TrackCount plain;
    TrackCount roulette;
    for (int i = 0; i < 200; ++i) {
        LatticeLine a(thick, 1);
        kRatio(a, random, plain);
        LatticeLine b(thick, 1);
        kRoulette(b, random, roulette);
    }
    // Ratio tracking ends early only where 1 − μ/b is exactly 0: in the first half it is.
    EXPECT_LE(roulette.lookups, plain.lookups);
    EXPECT_LT(roulette.lookups / 200, 50u);
}

}  // namespace
}  // namespace probebake
