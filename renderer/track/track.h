// What every tracker has in common: lines, traits, ends of flights, counters.
//
// A tracker takes a particle along a line through a medium until something happens to it, and
// yields where, what, and a weight per channel; averages over flights of weight × anything are the
// integrals of the radiative transfer equation. It knows the medium by its line alone:
//
//   bool next(Segment<N>&)          the pieces of the line in order, with bounds (spectrum.h)
//   Coefficients<N> at(double t)    a look-up in the piece that next() gave last
//
// b: free-path-sampling coefficient. Exponential sampling begins anew in every piece (it has no
// memory), with t local to the piece, in double: t + dt ≠ t up to b·t = 1e15 (in float 6 % of the
// steps are lost at 1e6). Pieces with b ≤ 0 are passed: 0/0 never arises.
#pragma once

#include <cmath>
#include <cstdint>

#include "volume/spectrum.h"

namespace probebake {

/// What a job's medium asks for; decided once, so that the innermost loop tests nothing.
template <int Channels, bool Absorbs, bool Emits>
struct TrackTraits {
    static constexpr int kChannels = Channels;
    static constexpr bool kAbsorbs = Absorbs;
    static constexpr bool kEmits = Emits;
};

enum class Event : uint8_t { kEscape, kScatter, kAbsorb };

struct FlightEnd {
    Event event = Event::kEscape;
    double t = 0.0;        // of the collision, along the line
    bool control = false;  // in the control component, without a look-up
};

struct TrackCount {
    uint64_t leaves = 0;      // pieces entered
    uint64_t lookups = 0;     // of the medium
    uint64_t collisions = 0;  // real ones
    uint64_t null_collisions = 0;
    uint64_t control_collisions = 0;  // real ones that needed no look-up
    uint64_t faults = 0;              // flights ended by kMaxSteps, majorants that did not bound

    TrackCount& operator+=(const TrackCount& o) {
        leaves += o.leaves;
        lookups += o.lookups;
        collisions += o.collisions;
        null_collisions += o.null_collisions;
        control_collisions += o.control_collisions;
        faults += o.faults;
        return *this;
    }
    bool operator==(const TrackCount&) const = default;
};

/// Collisions in one flight beyond which something is wrong with its medium; it ends with weight 0
/// and is counted as a fault.
inline constexpr uint64_t kMaxSteps = 10'000'000;

/// An exponential distance; finite for all b > 0 because uniform() never is 1. 1 − uniform() is
/// exact (53 bits), so that log is as good as log1p and half as long.
template <class Random>
double exponential(Random& random, double b) {
    return -std::log(1.0 - random.uniform()) / b;
}

/// A line seen in one channel.
template <class Line>
class ChannelLine {
  public:
    ChannelLine(Line& line, int channel) : line_(line), channel_(channel) {}

    bool next(Segment<1>& segment) {
        if (!line_.next(all_)) return false;
        segment = {all_.t0, all_.t1, one(all_.least), one(all_.most)};
        return true;
    }
    Coefficients<1> at(double t) { return one(line_.at(t)); }

  private:
    template <int N>
    Coefficients<1> one(const Coefficients<N>& c) const {
        return {Spectrum<1>(c.absorption[channel_]), Spectrum<1>(c.scattering[channel_])};
    }

    static constexpr int kN = Line::kChannels;
    Line& line_;
    int channel_;
    Segment<kN> all_;
};

/// Called at every collision candidate, null ones included, right after its look-up, with the
/// weight over b that emission there counts with. This one drops it.
struct CollectNothing {
    template <int N>
    void operator()(double /*t*/, const Spectrum<N>& /*weight_over_b*/) const {}
};

}  // namespace probebake
