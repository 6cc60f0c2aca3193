// Gradient noise (Perlin 2002, "Improving Noise", with hashed instead of tabled gradients) and the
// sums of octaves that the landscapes are made of.
//
// A value is a pure function of (key, position), about in [−1, 1] with mean 0 and standard
// deviation near 0.35. Only +, −, ×, floor and integer hashes: the same bits on every machine.
#pragma once

#include <algorithm>
#include <cstdint>

#include "math/vec.h"

namespace probebake::worldgen {

struct Octaves {
    double wavelength_m;  // of the first octave; each following one has half of it
    int count;
    double gain = 0.5;  // amplitude of each octave relative to the one before
};

class Noise {
  public:
    explicit Noise(uint64_t key) : key_(key) {}

    /// One octave; the lattice has edge 1.
    double at(const Vec2& p) const;
    double at(const Vec3& p) const;
    /// Octaves added up, normalised so that the amplitudes sum to 1.
    double fbm(const Vec2& p_m, const Octaves& octaves) const;
    double fbm(const Vec3& p_m, const Octaves& octaves) const;
    /// Octaves of 1 − |noise| (Musgrave 1994): sharp crests, about in [0, 1].
    double ridged(const Vec2& p_m, const Octaves& octaves) const;
    /// A displacement for domain warping, about in [−1, 1]².
    Vec2 warp(const Vec2& p_m, const Octaves& octaves) const;

  private:
    uint64_t key_;
};

/// 0 below `from`, 1 above `to`, smooth between; `from` > `to` gives the falling curve.
inline double smooth_step(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// The height turned into benches `step_m` apart: flat for the lower half, then steep.
double ledges(double height_m, double step_m);

inline double mix(double a, double b, double t) { return a + (b - a) * t; }
inline Rgb mix(const Rgb& a, const Rgb& b, double t) { return a + (b - a) * static_cast<float>(t); }

}  // namespace probebake::worldgen
