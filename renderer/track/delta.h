// Delta tracking (Woodcock et al. 1965) and its weighted form (Galtier et al. 2013), in one
// channel.
//
//   DeltaTracker      t += Exp(b); real with probability μt/b, absorbed or scattered by μa : μs.
//                     Weight 1. Unbiased where μt ≤ b.
//   WeightedDelta     w⋆ = μ⋆ / (b P⋆), P⋆ = |μ⋆| / (μa + μs + |b − μt|). Unbiased for any b > 0
//                     where μt > 0; weights are signed where μt > b = f μt, and the relative
//                     variance of the transmittance is then e^(τ(2−f)/f) − 1.
#pragma once

#include "track/track.h"

namespace probebake {

struct DeltaTracker {
    static constexpr bool kScalar = true;
    static constexpr bool kDecomposes = false;
    static constexpr const char* kName = "delta";

    template <class Traits, class Line, class Random, class Collect>
    static FlightEnd fly(Line& line, Spectrum<1>& w, Random& random, TrackCount& count,
                         Collect&& collect) {
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
                    w = Spectrum<1>();
                    return {Event::kAbsorb, leaf.t0 + s};
                }
                ++count.lookups;
                const Coefficients<1> mu = line.at(leaf.t0 + s);
                if constexpr (Traits::kEmits) collect(leaf.t0 + s, w * (1.0 / b));
                const double u = random.uniform() * b;
                if (u < mu.scattering[0]) {
                    ++count.collisions;
                    return {Event::kScatter, leaf.t0 + s};
                }
                if constexpr (Traits::kAbsorbs) {
                    if (u < mu.scattering[0] + mu.absorption[0]) {
                        ++count.collisions;
                        return {Event::kAbsorb, leaf.t0 + s};
                    }
                }
                ++count.null_collisions;
            }
        }
        return {};
    }
};

struct WeightedDelta {
    static constexpr bool kScalar = true;
    static constexpr bool kDecomposes = false;
    static constexpr const char* kName = "weighted_delta";

    template <class Traits, class Line, class Random, class Collect>
    static FlightEnd fly(Line& line, Spectrum<1>& w, Random& random, TrackCount& count,
                         Collect&& collect) {
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
                    w = Spectrum<1>();
                    return {Event::kAbsorb, leaf.t0 + s};
                }
                ++count.lookups;
                const Coefficients<1> mu = line.at(leaf.t0 + s);
                if constexpr (Traits::kEmits) collect(leaf.t0 + s, w * (1.0 / b));
                const double null = b - mu.extinction()[0];
                const double sum = mu.extinction()[0] + std::abs(null);
                const double u = random.uniform() * sum;
                w *= sum / b;  // of every real event: μ⋆ / (b P⋆)
                if (u < mu.scattering[0]) {
                    ++count.collisions;
                    return {Event::kScatter, leaf.t0 + s};
                }
                if constexpr (Traits::kAbsorbs) {
                    if (u < mu.extinction()[0]) {
                        ++count.collisions;
                        return {Event::kAbsorb, leaf.t0 + s};
                    }
                }
                if (null < 0.0) w *= -1.0;
                ++count.null_collisions;
            }
        }
        return {};
    }
};

}  // namespace probebake
