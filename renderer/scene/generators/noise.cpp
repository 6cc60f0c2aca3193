#include "scene/generators/noise.h"

#include <cmath>

#include "math/random.h"

namespace probebake::worldgen {
namespace {

double fade(double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); }

uint64_t lattice_hash(uint64_t key, int64_t x, int64_t y, int64_t z) {
    return mix64(key ^ (static_cast<uint64_t>(x) * 0x9E3779B97F4A7C15ull +
                        static_cast<uint64_t>(y) * 0xC2B2AE3D27D4EB4Full +
                        static_cast<uint64_t>(z) * 0x165667B19E3779F9ull));
}

/// 21 bits of the hash as a number in [−1, 1).
double signed_part(uint64_t hash, int part) {
    return static_cast<double>((hash >> (21 * part)) & 0x1FFFFF) * 0x1.0p-20 - 1.0;
}

double gradient(uint64_t hash, double x, double z) {
    return signed_part(hash, 0) * x + signed_part(hash, 1) * z;
}

double gradient(uint64_t hash, double x, double y, double z) {
    return signed_part(hash, 0) * x + signed_part(hash, 1) * y + signed_part(hash, 2) * z;
}

// Every octave is turned against the one before, so that the lattices never line up.
Vec2 next_octave(const Vec2& p) {
    return {2.0 * (0.8 * p.x - 0.6 * p.y) + 13.7, 2.0 * (0.6 * p.x + 0.8 * p.y) + 41.3};
}
Vec3 next_octave(const Vec3& p) {
    return {2.0 * (0.8 * p.x - 0.6 * p.z) + 13.7, 2.0 * p.y + 7.9,
            2.0 * (0.6 * p.x + 0.8 * p.z) + 41.3};
}

template <class Point, class Value>
double sum_octaves(Point p, const Octaves& octaves, Value value) {
    double sum = 0.0;
    double amplitude = 1.0;
    double total = 0.0;
    for (int i = 0; i < octaves.count; ++i) {
        sum += amplitude * value(p);
        total += amplitude;
        amplitude *= octaves.gain;
        p = next_octave(p);
    }
    return sum / total;
}

}  // namespace

double ledges(double height_m, double step_m) {
    const double t = height_m / step_m;
    const double step = std::floor(t);
    return step_m * (step + smooth_step(0.5, 1.0, t - step));
}

double Noise::at(const Vec2& p) const {
    const double fx = std::floor(p.x);
    const double fz = std::floor(p.y);
    const auto ix = static_cast<int64_t>(fx);
    const auto iz = static_cast<int64_t>(fz);
    const double x = p.x - fx;
    const double z = p.y - fz;
    const double g00 = gradient(lattice_hash(key_, ix, 0, iz), x, z);
    const double g10 = gradient(lattice_hash(key_, ix + 1, 0, iz), x - 1.0, z);
    const double g01 = gradient(lattice_hash(key_, ix, 0, iz + 1), x, z - 1.0);
    const double g11 = gradient(lattice_hash(key_, ix + 1, 0, iz + 1), x - 1.0, z - 1.0);
    const double u = fade(x);
    return 1.6 * mix(mix(g00, g10, u), mix(g01, g11, u), fade(z));
}

double Noise::at(const Vec3& p) const {
    const double fx = std::floor(p.x);
    const double fy = std::floor(p.y);
    const double fz = std::floor(p.z);
    const auto ix = static_cast<int64_t>(fx);
    const auto iy = static_cast<int64_t>(fy);
    const auto iz = static_cast<int64_t>(fz);
    const double x = p.x - fx;
    const double y = p.y - fy;
    const double z = p.z - fz;
    const double u = fade(x);
    const double w = fade(z);
    double layer[2];
    for (int dy = 0; dy < 2; ++dy) {
        const auto corner = [&](int dx, int dz) {
            return gradient(lattice_hash(key_, ix + dx, iy + dy, iz + dz), x - dx, y - dy, z - dz);
        };
        layer[dy] = mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), w);
    }
    return 1.6 * mix(layer[0], layer[1], fade(y));
}

double Noise::fbm(const Vec2& p_m, const Octaves& octaves) const {
    return sum_octaves(p_m / octaves.wavelength_m, octaves, [&](const Vec2& p) { return at(p); });
}

double Noise::fbm(const Vec3& p_m, const Octaves& octaves) const {
    return sum_octaves(p_m / octaves.wavelength_m, octaves, [&](const Vec3& p) { return at(p); });
}

double Noise::ridged(const Vec2& p_m, const Octaves& octaves) const {
    return sum_octaves(p_m / octaves.wavelength_m, octaves, [&](const Vec2& p) {
        const double crest = 1.0 - std::min(1.0, std::abs(at(p)) * 1.4);
        return crest * crest;
    });
}

Vec2 Noise::warp(const Vec2& p_m, const Octaves& octaves) const {
    return {fbm(p_m, octaves), fbm(p_m + Vec2(371.3, 1291.7), octaves)};
}

}  // namespace probebake::worldgen
