// DensityGrid: a scalar field on an integer lattice, trilinear between, 0 outside.
//
// OpenVDB's index convention: the value of voxel (i, j, k) is what a look-up AT (i, j, k) gives;
// cell (i, j, k) lies between lattice points i and i + 1. Bricks of 8³ cells keep their own 9³
// lattice values, so that a look-up touches one brick:
//
//   table, brick (bx, by, bz) at (bz·ny + by)·nx + bx:  number of a brick's values,
//                                    or kConstant | number of a constant (0: the constant 0)
//   values of a brick:  (z·9 + y)·9 + x, float, or half where every value of the grid is one
//
// Values are finite and not negative. The lattice points on the border of the box of cells are 0
// wherever the maker's box holds all that is not.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <vector>

#include "math/vec.h"

namespace probebake {

class DensityGrid {
  public:
    static constexpr int kBrickLog2 = 3;
    static constexpr int kBrick = 1 << kBrickLog2;  // cells per side
    static constexpr int kSide = kBrick + 1;        // lattice points per side
    static constexpr size_t kBrickValues = size_t{kSide} * kSide * kSide;
    static constexpr int kMaxCells = 1 << 15;                  // per axis
    static constexpr uint64_t kMaxBricks = uint64_t{1} << 27;  // of the table

    /// The lattice values of one brick.
    using BrickValues = std::span<float, kBrickValues>;
    /// Fills in the brick whose lowest lattice point is `low`; false: everything is 0. Called
    /// from many threads at once.
    using FillBrick = std::function<bool(const IVec3& low, BrickValues values)>;

    struct BuildParams {
        IVec3 low{0};    // lowest lattice point
        IVec3 cells{1};  // extent
    };

    /// What a grid consists of, as grid_file.h keeps it.
    struct Arrays {
        IVec3 low{0};
        IVec3 cells{0};
        std::vector<uint32_t> table;
        std::vector<float> constants;
        std::vector<float> floats;
        std::vector<uint16_t> halves;
    };

    DensityGrid() = default;
    /// Throws std::invalid_argument for arrays that do not fit together or hold what no density is.
    explicit DensityGrid(Arrays arrays);
    /// Throws std::length_error for an extent beyond kMaxCells or kMaxBricks.
    static void check_extent(const BuildParams& params);
    /// In parallel on the calling arena. Throws as check_extent, and BadDensity for values that are
    /// negative or not finite.
    DensityGrid(const BuildParams& params, const FillBrick& fill);

    const IVec3& low() const { return low_; }
    const IVec3& cells() const { return cells_; }
    /// Bricks per axis.
    const IVec3& bricks() const { return bricks_; }

    /// Trilinear at a place in index space.
    double sample(const Vec3& index) const;
    /// The lattice point's own value.
    float value(const IVec3& lattice) const;
    /// Smallest and largest lattice value within [low, high], both ends included and in one brick
    /// (`low` selects it).
    struct Bounds {
        float least = 0.0f;
        float most = 0.0f;
    };
    Bounds bounds_in_brick(const IVec3& low, const IVec3& high) const;
    Bounds brick_bounds(const IVec3& brick) const;

    bool is_half() const { return !half_.empty(); }
    std::span<const uint32_t> table() const { return table_; }
    std::span<const float> constants() const { return constants_; }
    std::span<const float> floats() const { return float_; }
    std::span<const uint16_t> halves() const { return half_; }
    uint64_t stored_bricks() const;
    uint64_t memory_bytes() const;

  private:
    static constexpr uint32_t kConstant = 0x8000'0000u;

    uint32_t entry(const IVec3& brick) const {
        return table_[(static_cast<size_t>(brick.z) * static_cast<size_t>(bricks_.y) +
                       static_cast<size_t>(brick.y)) *
                          static_cast<size_t>(bricks_.x) +
                      static_cast<size_t>(brick.x)];
    }
    float stored(size_t at) const;
    void keep_as_half_if_exact();

    IVec3 low_{0};
    IVec3 cells_{0};
    IVec3 bricks_{0};
    Vec3 origin_{0.0};  // low_ and cells_ again, as look-ups need them
    Vec3 extent_{0.0};
    std::vector<uint32_t> table_;
    std::vector<float> constants_{0.0f};
    std::vector<float> float_;  // one of these two is empty
    std::vector<uint16_t> half_;
};

/// Values that no density can have.
class BadDensity : public std::runtime_error {
  public:
    BadDensity(uint64_t not_finite, uint64_t negative, const IVec3& first);

    uint64_t not_finite() const { return not_finite_; }
    uint64_t negative() const { return negative_; }
    const IVec3& first() const { return first_; }

  private:
    uint64_t not_finite_;
    uint64_t negative_;
    IVec3 first_;
};

}  // namespace probebake
