// Spectral tracking (Kutz et al. 2017, section 5): one flight for all channels.
//
// b is the largest extinction over the channels; a collision is absorption, scattering or null with
// probabilities shared by the channels, P⋆ = s⋆ / Σ s, and w_λ *= μ⋆,λ / (b P⋆):
//
//   scheme            s⋆                   local weight (non-negative μ)
//   max               max |μ⋆,λ|           ≤ 3; ≤ 2 without absorption events (supplemental 1.2)
//   average           mean |μ⋆,λ|
//   history max       max |w_λ μ⋆,λ|
//   history average   mean |w_λ μ⋆,λ|      Σ w = N after every event (supplemental 1.3)
//
// Reduced termination, for what is not collected at absorption events: kNone sets Pa = 0 and
// normalises again, kMerged adds Pa to Ps, kGap takes Ps = max μs/b and Pn = max μn/b and leaves
// Pa the rest (where there is one; as kNone otherwise). Unbiased where P⋆ > 0 wherever w μ⋆ ≠ 0.
//
// With decomposition: the control is chosen with Pc = mean|w μc| / (mean|w| b) before any look-up.
#pragma once

#include "track/track.h"

namespace probebake {

enum class Scheme : uint8_t { kMax, kAverage, kHistoryMax, kHistoryAverage };
enum class Termination : uint8_t { kFull, kNone, kMerged, kGap };

/// Probabilities of absorption, scattering and a null collision; all 0 where nothing can happen.
struct EventProbabilities {
    double absorb = 0.0;
    double scatter = 0.0;
    double null = 0.0;
};

template <Scheme S, class T>
auto scheme_weight(const T& w, const T& mu) {
    if constexpr (S == Scheme::kMax) return mu.max_abs();
    if constexpr (S == Scheme::kAverage) return mu.mean_abs();
    if constexpr (S == Scheme::kHistoryMax) return (w * mu).max_abs();
    if constexpr (S == Scheme::kHistoryAverage) return (w * mu).mean_abs();
}

template <Scheme S, Termination K, class T>
EventProbabilities event_probabilities(const T& w, const T& absorb, const T& scatter, const T& null,
                                       double b) {
    EventProbabilities p{double{scheme_weight<S>(w, absorb)}, double{scheme_weight<S>(w, scatter)},
                         double{scheme_weight<S>(w, null)}};
    if constexpr (K == Termination::kMerged) {
        // Where nothing scatters, the weight of scattering is 0: the path ends well.
        p.scatter += p.absorb;
        p.absorb = 0.0;
    } else if constexpr (K == Termination::kGap) {
        const double ps = double{scatter.max_abs()} / b;
        const double pn = double{null.max_abs()} / b;
        if (ps + pn <= 1.0) return {1.0 - ps - pn, ps, pn};
        p.absorb = 0.0;
    } else if constexpr (K == Termination::kNone) {
        p.absorb = 0.0;
    }
    const double sum = p.absorb + p.scatter + p.null;
    if (!(sum > 0.0)) return {};
    return {p.absorb / sum, p.scatter / sum, p.null / sum};
}

/// Chooses one of the three and makes its weight part of w: w_λ *= μ⋆,λ / (rate P⋆). A null
/// collision comes as kEscape.
template <Scheme S, Termination K, class T, class Random>
Event choose_event(T& w, const T& absorb, const T& scatter, const T& null, double rate, double b,
                   Random& random) {
    const EventProbabilities p = event_probabilities<S, K>(w, absorb, scatter, null, b);
    using Value = std::decay_t<decltype(w[0])>;
    const auto take = [&](const T& mu, double probability, Event event) {
        w *= mu * static_cast<Value>(1.0 / (rate * probability));
        return event;
    };
    const double u = random.uniform();
    if (u < p.null) return take(null, p.null, Event::kEscape);
    if (u < p.null + p.scatter) return take(scatter, p.scatter, Event::kScatter);
    if (p.absorb > 0.0) return take(absorb, p.absorb, Event::kAbsorb);
    if (p.scatter > 0.0) return take(scatter, p.scatter, Event::kScatter);  // u at 1 − rounding
    if (p.null > 0.0) return take(null, p.null, Event::kEscape);
    w = T();
    return Event::kAbsorb;  // no channel has any weight left
}

template <Scheme S, Termination K = Termination::kFull, bool Decompose = false>
struct SpectralTracker {
    static constexpr bool kScalar = false;
    static constexpr bool kDecomposes = Decompose;

    template <class Traits, class Line, class Random, class Collect>
    static FlightEnd fly(Line& line, Spectrum<Traits::kChannels>& w, Random& random,
                         TrackCount& count, Collect&& collect) {
        constexpr int N = Traits::kChannels;
        Segment<N> leaf;
        uint64_t steps = 0;
        while (line.next(leaf)) {
            ++count.leaves;
            const Spectrum<N> most = leaf.most.extinction();
            double b = most.max();
            if (!(b > 0.0)) continue;
            // Emission is seen at residual collisions alone, which a homogeneous leaf needs too.
            if constexpr (Decompose && Traits::kEmits) b *= 1.25;
            const Spectrum<N> control = leaf.least.extinction();
            for (double s = 0.0;;) {
                s += exponential(random, b);
                if (!(s < leaf.length())) break;
                if (++steps > kMaxSteps) {
                    ++count.faults;
                    w = Spectrum<N>();
                    return {Event::kAbsorb, leaf.t0 + s};
                }
                const double t = leaf.t0 + s;
                double pc = 0.0;
                if constexpr (Decompose) {
                    const double all = w.mean_abs();
                    if (!(all > 0.0)) return {Event::kAbsorb, t};
                    pc = (w * control).mean_abs() / (all * b);
                    if (random.uniform() < pc) {
                        ++count.collisions;
                        ++count.control_collisions;
                        const Event event =
                            choose_event<S, K>(w, leaf.least.absorption, leaf.least.scattering,
                                               Spectrum<N>(), pc * b, control.max(), random);
                        return {event, t, true};
                    }
                }
                ++count.lookups;
                Coefficients<N> mu = line.at(t);
                const Spectrum<N> null = Spectrum<N>(b) - mu.extinction();
                if constexpr (Traits::kEmits) collect(t, w * (1.0 / ((1.0 - pc) * b)));
                if constexpr (Decompose) mu = mu - leaf.least;
                const Event event = choose_event<S, K>(w, mu.absorption, mu.scattering, null,
                                                       (1.0 - pc) * b, b, random);
                if (event != Event::kEscape) {
                    ++count.collisions;
                    return {event, t};
                }
                ++count.null_collisions;
            }
        }
        return {};
    }
};

}  // namespace probebake
