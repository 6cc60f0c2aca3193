// Random numbers as a pure function of a key, never of a thread or of the order of calls.
//
// SplitMix64 (Steele, Lea, Flood 2014): a 64-bit counter through a bijective finaliser. A stream is
// named by hashing what it belongs to: (seed, probe, owner face, pixel, sample).
#pragma once

#include <cstdint>
#include <initializer_list>

namespace probebake {

/// Bijective 64-bit finaliser (SplitMix64's).
constexpr uint64_t mix64(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
    return x ^ (x >> 31);
}

/// One key from several parts; order matters.
constexpr uint64_t random_key(std::initializer_list<uint64_t> parts) {
    uint64_t key = 0x243F6A8885A308D3ull;
    for (const uint64_t part : parts) key = mix64(key + 0x9E3779B97F4A7C15ull + mix64(part));
    return key;
}

class RandomStream {
  public:
    explicit constexpr RandomStream(uint64_t key) : state_(key) {}

    constexpr uint64_t next() {
        state_ += 0x9E3779B97F4A7C15ull;
        return mix64(state_);
    }
    /// Uniform in [0, 1), 53 bits.
    constexpr double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
    /// Uniform in [0, n), n ≥ 1; bias below 2^-32 for n < 2^32.
    constexpr uint64_t below(uint64_t n) {
        return static_cast<uint64_t>((static_cast<unsigned __int128>(next()) * n) >> 64);
    }

  private:
    uint64_t state_;
};

}  // namespace probebake
