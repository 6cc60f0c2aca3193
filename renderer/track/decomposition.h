// Decomposition tracking (Kutz et al. 2017, section 4), in one channel: the medium is the sum of a
// constant control in every leaf and the residual; only residual collisions look anything up.
//
//   AnalogDecomposition    the earlier of an exponential distance in the control and a delta
//                          flight through the residual. Weight 1. Unbiased where
//                          0 ≤ μc ≤ μt ≤ br + μc: the control is the minorant.
//   WeightedDecomposition  t += Exp(μc + br), control with probability μc / (μc + br) before any
//                          look-up, else weighted delta tracking of the signed residual. Any
//                          control; unbiased where br > 0 wherever μt ≠ μc. br = 0 would be a
//                          silent bias, hence br = max(max − μc, μc − min, max/4).
//
// Emission is collected at residual collisions, with w/br: control ones look nothing up. Where the
// medium emits, br is at least max/4, so that a nearly homogeneous leaf is seen emitting too.
#pragma once

#include <algorithm>
#include <limits>

#include "track/track.h"

namespace probebake {

namespace detail {

/// Which real event a collision in a component is: by its own μa : μs.
template <class Traits, class Random>
Event real_event(const Coefficients<1>& mu, Random& random) {
    if constexpr (Traits::kAbsorbs) {
        if (random.uniform() * mu.extinction()[0] >= mu.scattering[0]) return Event::kAbsorb;
    }
    return Event::kScatter;
}

}  // namespace detail

struct AnalogDecomposition {
    static constexpr bool kScalar = true;
    static constexpr bool kDecomposes = true;
    static constexpr const char* kName = "analog_decomposition";

    template <class Traits, class Line, class Random, class Collect>
    static FlightEnd fly(Line& line, Spectrum<1>& w, Random& random, TrackCount& count,
                         Collect&& collect) {
        Segment<1> leaf;
        uint64_t steps = 0;
        while (line.next(leaf)) {
            ++count.leaves;
            const double most = leaf.most.extinction()[0];
            if (!(most > 0.0)) continue;
            const double control = leaf.least.extinction()[0];
            double residual = most - control;
            if constexpr (Traits::kEmits) residual = std::max(residual, 0.25 * most);
            const double control_hit = control > 0.0 ? exponential(random, control)
                                                     : std::numeric_limits<double>::infinity();
            const double end = std::min(control_hit, leaf.length());
            if (residual > 0.0) {
                for (double s = 0.0;;) {
                    s += exponential(random, residual);
                    if (!(s < end)) break;
                    if (++steps > kMaxSteps) {
                        ++count.faults;
                        w = Spectrum<1>();
                        return {Event::kAbsorb, leaf.t0 + s};
                    }
                    ++count.lookups;
                    const Coefficients<1> mu = line.at(leaf.t0 + s) - leaf.least;
                    if constexpr (Traits::kEmits) collect(leaf.t0 + s, w * (1.0 / residual));
                    if (random.uniform() * residual < mu.extinction()[0]) {
                        ++count.collisions;
                        return {detail::real_event<Traits>(mu, random), leaf.t0 + s};
                    }
                    ++count.null_collisions;
                }
            }
            if (control_hit < leaf.length()) {
                ++count.collisions;
                ++count.control_collisions;
                return {detail::real_event<Traits>(leaf.least, random), leaf.t0 + control_hit,
                        true};
            }
        }
        return {};
    }
};

/// The control is the leaf's minorant, or, for studies, this share of its majorant.
struct ControlSetting {
    double share_of_majorant = -1.0;  // below 0: the minorant
};

struct WeightedDecomposition {
    static constexpr bool kScalar = true;
    static constexpr bool kDecomposes = true;
    static constexpr const char* kName = "weighted_decomposition";

    template <class Traits, class Line, class Random, class Collect>
    static FlightEnd fly(Line& line, Spectrum<1>& w, Random& random, TrackCount& count,
                         Collect&& collect, const ControlSetting& setting = {}) {
        Segment<1> leaf;
        uint64_t steps = 0;
        while (line.next(leaf)) {
            ++count.leaves;
            const double most = leaf.most.extinction()[0];
            if (!(most > 0.0)) continue;
            const Coefficients<1> control = setting.share_of_majorant < 0.0
                                                ? leaf.least
                                                : leaf.most * setting.share_of_majorant;
            const double mc = control.extinction()[0];
            const double least = leaf.least.extinction()[0];
            double br = std::max(most - mc, mc - least);
            // Equal bounds and an equal control leave no residual at all.
            if (br > 0.0 || Traits::kEmits) br = std::max(br, 0.25 * most);
            const double b = mc + br;
            for (double s = 0.0;;) {
                s += exponential(random, b);
                if (!(s < leaf.length())) break;
                if (++steps > kMaxSteps) {
                    ++count.faults;
                    w = Spectrum<1>();
                    return {Event::kAbsorb, leaf.t0 + s};
                }
                if (random.uniform() * b < mc) {
                    ++count.collisions;
                    ++count.control_collisions;
                    return {detail::real_event<Traits>(control, random), leaf.t0 + s, true};
                }
                ++count.lookups;
                const Coefficients<1> mu = line.at(leaf.t0 + s) - control;
                if constexpr (Traits::kEmits) collect(leaf.t0 + s, w * (1.0 / br));
                const double null = br - mu.extinction()[0];
                const double scatter = std::abs(mu.scattering[0]);
                const double real = scatter + std::abs(mu.absorption[0]);
                const double sum = real + std::abs(null);
                if (!(sum > 0.0)) {
                    ++count.null_collisions;
                    continue;
                }
                const double u = random.uniform() * sum;
                w *= sum / br;
                if (u < scatter) {
                    ++count.collisions;
                    if (mu.scattering[0] < 0.0) w *= -1.0;
                    return {Event::kScatter, leaf.t0 + s};
                }
                if constexpr (Traits::kAbsorbs) {
                    if (u < real) {
                        ++count.collisions;
                        if (mu.absorption[0] < 0.0) w *= -1.0;
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
