// The numbers that one path is made of: a few given ones first (low-discrepancy points over the
// samples of a pixel), then a keyed stream.
#pragma once

#include <array>

#include "math/random.h"

namespace probebake {

class PathRandom {
  public:
    static constexpr int kMostLeading = 4;

    explicit PathRandom(uint64_t key) : stream_(key) {}
    /// The first `count` numbers are leading[0..count).
    PathRandom(uint64_t key, const std::array<double, kMostLeading>& leading, int count)
        : leading_(leading), count_(count), stream_(key) {}

    double uniform() {
        if (used_ < count_) return leading_[static_cast<size_t>(used_++)];
        return stream_.uniform();
    }

  private:
    std::array<double, kMostLeading> leading_{};
    int count_ = 0;
    int used_ = 0;
    RandomStream stream_;
};

}  // namespace probebake
