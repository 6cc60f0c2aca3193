// A few channels side by side: coefficients, throughputs, transmittances.
//
// N is 1 (gray) or 3 (red, green, blue); everything is per channel.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "math/vec.h"

namespace probebake {

template <int N, class T = double>
class Spectrum {
  public:
    static constexpr int kChannels = N;

    constexpr Spectrum() = default;
    explicit constexpr Spectrum(T all) { values_.fill(all); }
    explicit constexpr Spectrum(const std::array<T, static_cast<size_t>(N)>& values)
        : values_(values) {}

    constexpr T& operator[](int c) { return values_[static_cast<size_t>(c)]; }
    constexpr const T& operator[](int c) const { return values_[static_cast<size_t>(c)]; }

    constexpr Spectrum& operator+=(const Spectrum& o) {
        for (int c = 0; c < N; ++c) (*this)[c] += o[c];
        return *this;
    }
    constexpr Spectrum& operator*=(const Spectrum& o) {
        for (int c = 0; c < N; ++c) (*this)[c] *= o[c];
        return *this;
    }
    constexpr Spectrum& operator*=(T x) {
        for (int c = 0; c < N; ++c) (*this)[c] *= x;
        return *this;
    }
    friend constexpr Spectrum operator+(Spectrum a, const Spectrum& b) { return a += b; }
    friend constexpr Spectrum operator-(Spectrum a, const Spectrum& b) {
        for (int c = 0; c < N; ++c) a[c] -= b[c];
        return a;
    }
    friend constexpr Spectrum operator*(Spectrum a, const Spectrum& b) { return a *= b; }
    friend constexpr Spectrum operator*(Spectrum a, T x) { return a *= x; }
    bool operator==(const Spectrum&) const = default;

    constexpr T max() const { return *std::max_element(values_.begin(), values_.end()); }
    constexpr T min() const { return *std::min_element(values_.begin(), values_.end()); }
    constexpr T sum() const {
        T sum = T(0);
        for (const T v : values_) sum += v;
        return sum;
    }
    constexpr T mean() const { return sum() / T(N); }
    T max_abs() const {
        T most = T(0);
        for (const T v : values_) most = std::max(most, std::abs(v));
        return most;
    }
    T mean_abs() const {
        T sum = T(0);
        for (const T v : values_) sum += std::abs(v);
        return sum / T(N);
    }

  private:
    std::array<T, static_cast<size_t>(N)> values_{};
};

/// exp of every channel.
template <int N>
Spectrum<N> exp(const Spectrum<N>& x) {
    Spectrum<N> out;
    for (int c = 0; c < N; ++c) out[c] = std::exp(x[c]);
    return out;
}

inline Spectrum<3> to_spectrum(const Rgb& rgb) {
    return Spectrum<3>({double{rgb.r}, double{rgb.g}, double{rgb.b}});
}
inline Vec3 to_vec3(const Spectrum<3>& s) { return {s[0], s[1], s[2]}; }

/// Absorption and scattering, 1/m.
template <int N>
struct Coefficients {
    Spectrum<N> absorption;
    Spectrum<N> scattering;

    Spectrum<N> extinction() const { return absorption + scattering; }
    Coefficients& operator+=(const Coefficients& o) {
        absorption += o.absorption;
        scattering += o.scattering;
        return *this;
    }
    friend Coefficients operator-(const Coefficients& a, const Coefficients& b) {
        return {a.absorption - b.absorption, a.scattering - b.scattering};
    }
    friend Coefficients operator*(const Coefficients& a, double x) {
        return {a.absorption * x, a.scattering * x};
    }
};

/// A piece of a ray, t in metres, with bounds of the coefficients in it: least ≤ value ≤ most in
/// every channel, for absorption and scattering apart.
template <int N>
struct Segment {
    double t0 = 0.0;
    double t1 = 0.0;
    Coefficients<N> least;
    Coefficients<N> most;

    double length() const { return t1 - t0; }
};

}  // namespace probebake
