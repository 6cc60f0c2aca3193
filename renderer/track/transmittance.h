// Estimators of the transmittance exp(−∫ μt dt) of a line, per channel.
//
//   delta            1 or 0: whether a flight comes through; one channel
//   ratio            ∏ (1 − μt/b)                                (Novák et al. 2014)
//   ratio, roulette  the same; below 0.1 in every channel it survives with max T / 0.1
//   residual ratio   e^(−μc·len) ∏ (1 − (μt − μc)/μr), μr = max(max − μc, μc − min); the control μc
//                    is the minorant, which keeps T in [0, 1] (with the midpoint the mean squared
//                    error is some 200 times larger)
#pragma once

#include <algorithm>

#include "track/track.h"

namespace probebake {

template <bool Roulette>
struct RatioTracking {
    /// `collect` is called at every candidate with the emission's weight, transmittance included.
    template <class Traits, class Line, class Random, class Collect = CollectNothing>
    static Spectrum<Traits::kChannels> transmittance(Line& line, Random& random, TrackCount& count,
                                                     Collect&& collect = {}) {
        constexpr int N = Traits::kChannels;
        constexpr double kRouletteBelow = 0.1;
        Spectrum<N> result(1.0);
        Segment<N> leaf;
        uint64_t steps = 0;
        while (line.next(leaf)) {
            ++count.leaves;
            const double b = leaf.most.extinction().max();
            if (!(b > 0.0)) continue;
            for (double s = 0.0;;) {
                s += exponential(random, b);
                if (!(s < leaf.length())) break;
                if (++steps > kMaxSteps) {
                    ++count.faults;
                    return Spectrum<N>();
                }
                ++count.lookups;
                const Spectrum<N> mu = line.at(leaf.t0 + s).extinction();
                if constexpr (Traits::kEmits) collect(leaf.t0 + s, result * (1.0 / b));
                for (int c = 0; c < N; ++c) result[c] *= 1.0 - mu[c] / b;
                const double most = result.max_abs();
                if (!(most > 0.0)) return Spectrum<N>();
                if constexpr (Roulette) {
                    if (most < kRouletteBelow) {
                        const double survive = most / kRouletteBelow;
                        if (!(random.uniform() < survive)) return Spectrum<N>();
                        result *= 1.0 / survive;
                    }
                }
            }
        }
        return result;
    }
};

/// What the control of residual ratio tracking is: for tests, a place between the bounds.
struct ResidualRatio {
    template <class Traits, class Line, class Random>
    static Spectrum<Traits::kChannels> transmittance(Line& line, Random& random, TrackCount& count,
                                                     double between = 0.0) {
        constexpr int N = Traits::kChannels;
        constexpr double kRounding = 1e-14;
        Spectrum<N> result(1.0);
        Segment<N> leaf;
        uint64_t steps = 0;
        while (line.next(leaf)) {
            ++count.leaves;
            const Spectrum<N> most = leaf.most.extinction();
            if (!(most.max() > 0.0)) continue;
            const Spectrum<N> least = leaf.least.extinction();
            const Spectrum<N> control = least + (most - least) * between;
            result *= exp(control * -leaf.length());
            const double br = std::max((most - control).max(), (control - least).max());
            if (!(br > 0.0)) continue;
            for (double s = 0.0;;) {
                s += exponential(random, br);
                if (!(s < leaf.length())) break;
                if (++steps > kMaxSteps) {
                    ++count.faults;
                    return Spectrum<N>();
                }
                ++count.lookups;
                const Spectrum<N> mu = line.at(leaf.t0 + s).extinction();
                for (int c = 0; c < N; ++c) {
                    // At the majorant itself the factor is 0, and rounding must not make it less.
                    const double factor = 1.0 - (mu[c] - control[c]) / br;
                    result[c] *= std::abs(factor) < kRounding ? 0.0 : factor;
                }
            }
        }
        return result;
    }
};

/// 1 where a delta flight comes through, 0 where it does not; for gray media.
struct DeltaVisibility {
    template <class Traits, class Line, class Random>
    static Spectrum<1> transmittance(Line& line, Random& random, TrackCount& count) {
        static_assert(Traits::kChannels == 1);
        Segment<1> leaf;
        uint64_t steps = 0;
        while (line.next(leaf)) {
            ++count.leaves;
            const double b = leaf.most.extinction()[0];
            if (!(b > 0.0)) continue;
            for (double s = 0.0;;) {
                s += exponential(random, b);
                if (!(s < leaf.length())) break;
                if (++steps > kMaxSteps) {
                    ++count.faults;
                    return Spectrum<1>();
                }
                ++count.lookups;
                if (random.uniform() * b < line.at(leaf.t0 + s).extinction()[0]) {
                    return Spectrum<1>();
                }
            }
        }
        return Spectrum<1>(1.0);
    }
};

}  // namespace probebake
