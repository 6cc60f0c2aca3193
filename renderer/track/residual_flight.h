// Free-path-sampling residual ratio tracking: distances by decomposition tracking of the mean over
// the channels, throughput of every channel by residual ratio tracking at the same candidates (what
// the supplemental of Kutz et al. 2017 compares in figure 4, as we read its name; for studies).
//
// With μ̄ the mean over the channels, μc the leaf's minorant, μr = μ − μc, br ≥ max μr:
//
//   control collision      rate μ̄c          w *= μ⋆c / μ̄⋆c
//   residual collision     rate μ̄r          w *= μ⋆r / μ̄⋆r
//   null collision         rate br − μ̄r     w *= (br − μr) / (br − μ̄r)
//   a stretch of length s                   w *= e^(−(μc − μ̄c) s)
//
// Unbiased: the mean is 0 only where all channels are. Weights are not bounded where extinction is
// coloured. Emission as in decomposition.h.
#pragma once

#include <limits>

#include "track/track.h"

namespace probebake {

struct ResidualRatioFlight {
    static constexpr bool kScalar = false;
    static constexpr bool kDecomposes = true;
    static constexpr const char* kName = "residual_ratio_flight";

    template <class Traits, class Line, class Random, class Collect>
    static FlightEnd fly(Line& line, Spectrum<Traits::kChannels>& w, Random& random,
                         TrackCount& count, Collect&& collect) {
        constexpr int N = Traits::kChannels;
        Segment<N> leaf;
        uint64_t steps = 0;
        while (line.next(leaf)) {
            ++count.leaves;
            const Spectrum<N> most = leaf.most.extinction();
            if (!(most.max() > 0.0)) continue;
            const Spectrum<N> control = leaf.least.extinction();
            const double mean_control = control.mean();
            double br = (most - control).max();
            if constexpr (Traits::kEmits) br = std::max(br, 0.25 * most.max());
            const double control_hit = mean_control > 0.0 ? exponential(random, mean_control)
                                                          : std::numeric_limits<double>::infinity();
            const double end = std::min(control_hit, leaf.length());
            double s = 0.0;
            const auto advance_to = [&](double to) {
                w *= exp((control - Spectrum<N>(mean_control)) * (s - to));
                s = to;
            };
            while (br > 0.0) {
                const double next = s + exponential(random, br);
                if (!(next < end)) break;
                advance_to(next);
                if (++steps > kMaxSteps) {
                    ++count.faults;
                    w = Spectrum<N>();
                    return {Event::kAbsorb, leaf.t0 + s};
                }
                ++count.lookups;
                const Coefficients<N> mu = line.at(leaf.t0 + s) - leaf.least;
                if constexpr (Traits::kEmits) collect(leaf.t0 + s, w * (1.0 / br));
                const Spectrum<N> residual = mu.extinction();
                const double real = residual.mean();
                if (random.uniform() * br < real) {
                    ++count.collisions;
                    return {collide(mu, w, random), leaf.t0 + s};
                }
                ++count.null_collisions;
                for (int c = 0; c < N; ++c) w[c] *= (br - residual[c]) / (br - real);
            }
            advance_to(end);
            if (control_hit < leaf.length()) {
                ++count.collisions;
                ++count.control_collisions;
                return {collide(leaf.least, w, random), leaf.t0 + s, true};
            }
        }
        return {};
    }

  private:
    /// Which event it was, by the means over the channels.
    template <int N, class Random>
    static Event collide(const Coefficients<N>& mu, Spectrum<N>& w, Random& random) {
        const double scatter = mu.scattering.mean();
        const bool absorbed = random.uniform() * (scatter + mu.absorption.mean()) >= scatter;
        const Spectrum<N>& event = absorbed ? mu.absorption : mu.scattering;
        w *= event * (1.0 / event.mean());
        return absorbed ? Event::kAbsorb : Event::kScatter;
    }
};

}  // namespace probebake
