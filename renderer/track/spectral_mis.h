// Spectral multiple importance sampling (Miller, Georgiev, Jarosz 2019): the flight of one hero
// channel with that channel's own majorant, weighed by the densities of all.
//
// The hero is chosen with probability w_λ / Σw, that is by what the path so far would have been
// sampled with; p_λ, the density of the flight in channel λ, is analog delta tracking with b_λ, so
// that f_λ ∝ p_λ and
//
//   w_λ ← w_λ p_λ Σw / Σ_g w_g p_g          (Σw stays what it was)
//
// With one majorant for all channels this is history-aware average. Unbiased where the channels'
// densities together cover. Densities are carried relative to the channel with the smallest b:
// every factor is at most 1, one of them is 1, and they are normalised at every step.
//
// HomogeneousMis: the same where bounds are equal in every leaf: no look-ups, no null collisions,
// and absorption weighs the path instead of ending it.
#pragma once

#include "track/track.h"

namespace probebake {

namespace detail {

/// A channel drawn by weight; requires a positive sum.
template <int N, class Random>
int draw_channel(const Spectrum<N>& w, Random& random) {
    double u = random.uniform() * w.sum();
    int last = 0;
    for (int c = 0; c < N; ++c) {
        if (!(w[c] > 0.0)) continue;
        last = c;
        if (u < w[c]) return c;
        u -= w[c];
    }
    return last;
}

/// exp(−(b − min b) s) of every channel.
template <int N>
Spectrum<N> relative_survival(const Spectrum<N>& b, double s) {
    const double least = b.min();
    Spectrum<N> out;
    for (int c = 0; c < N; ++c) out[c] = b[c] == least ? 1.0 : std::exp((least - b[c]) * s);
    return out;
}

/// Scales w to the sum; w = 0 where nothing is left.
template <int N>
void normalise(Spectrum<N>& w, double sum) {
    const double now = w.sum();
    w *= now > 0.0 ? sum / now : 0.0;
}

}  // namespace detail

struct SpectralMis {
    static constexpr bool kScalar = false;
    static constexpr bool kDecomposes = false;
    static constexpr const char* kName = "spectral_mis";

    template <class Traits, class Line, class Random, class Collect>
    static FlightEnd fly(Line& line, Spectrum<Traits::kChannels>& w, Random& random,
                         TrackCount& count, Collect&& collect) {
        constexpr int N = Traits::kChannels;
        const double total = w.sum();
        if (!(total > 0.0)) return {Event::kAbsorb, 0.0};
        const int hero = detail::draw_channel(w, random);
        Segment<N> leaf;
        uint64_t steps = 0;
        while (line.next(leaf)) {
            ++count.leaves;
            const Spectrum<N> b = leaf.most.extinction();
            if (!(b.max() > 0.0)) continue;
            double s = 0.0;
            for (;;) {
                const double before = s;
                if (b[hero] > 0.0) s += exponential(random, b[hero]);
                if (!(b[hero] > 0.0) || !(s < leaf.length())) {
                    w *= detail::relative_survival(b, leaf.length() - before);
                    detail::normalise(w, total);
                    break;
                }
                const double t = leaf.t0 + s;
                if (++steps > kMaxSteps) {
                    ++count.faults;
                    w = Spectrum<N>();
                    return {Event::kAbsorb, t};
                }
                ++count.lookups;
                const Coefficients<N> mu = line.at(t);
                w *= detail::relative_survival(b, s - before);
                if constexpr (Traits::kEmits) {
                    // Density of a candidate here: Σ w b / Σ w over the channels.
                    const double density = (w * b).sum();
                    if (density > 0.0) collect(t, w * (total / density));
                }
                const double u = random.uniform() * b[hero];
                if (u < mu.scattering[hero]) {
                    ++count.collisions;
                    w *= mu.scattering;
                    detail::normalise(w, total);
                    return {Event::kScatter, t};
                }
                if constexpr (Traits::kAbsorbs) {
                    if (u < mu.scattering[hero] + mu.absorption[hero]) {
                        ++count.collisions;
                        w *= mu.absorption;
                        detail::normalise(w, total);
                        return {Event::kAbsorb, t};
                    }
                }
                ++count.null_collisions;
                for (int c = 0; c < N; ++c) {
                    w[c] *= std::max(0.0, b[c] - mu.extinction()[c]);
                }
                detail::normalise(w, total);
            }
        }
        return {};
    }
};

struct HomogeneousMis {
    static constexpr bool kScalar = false;
    static constexpr bool kDecomposes = false;
    static constexpr const char* kName = "closed_form";

    template <class Traits, class Line, class Random, class Collect>
    static FlightEnd fly(Line& line, Spectrum<Traits::kChannels>& w, Random& random,
                         TrackCount& count, Collect&& collect) {
        constexpr int N = Traits::kChannels;
        const double total = w.sum();
        if (!(total > 0.0)) return {Event::kAbsorb, 0.0};
        const int hero = detail::draw_channel(w, random);
        Segment<N> leaf;
        while (line.next(leaf)) {
            ++count.leaves;
            const Spectrum<N> b = leaf.most.extinction();
            if (!(b.max() > 0.0)) continue;
            const double s = b[hero] > 0.0 ? exponential(random, b[hero])
                                           : std::numeric_limits<double>::infinity();
            if (!(s < leaf.length())) {
                w *= detail::relative_survival(b, leaf.length());
                detail::normalise(w, total);
                continue;
            }
            w *= detail::relative_survival(b, s);
            ++count.collisions;
            ++count.control_collisions;
            if constexpr (Traits::kEmits) {
                line.at(leaf.t0 + s);
                const double density = (w * b).sum();
                if (density > 0.0) collect(leaf.t0 + s, w * (total / density));
            }
            w *= b;
            detail::normalise(w, total);
            for (int c = 0; c < N; ++c) {
                if (b[c] > 0.0) w[c] *= leaf.most.scattering[c] / b[c];
            }
            return {Event::kScatter, leaf.t0 + s, true};
        }
        return {};
    }
};

}  // namespace probebake
