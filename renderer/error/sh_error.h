// The error table as the thesis stores it: 9 real spherical-harmonic coefficients per child mask
// (Müller 2020, 3.2), fitted by least squares over the directions of a table.
//
// Layout: 256 rows of 9 floats, 9 KB. (Rows padded to a cache line measured no faster.)
// The fit is coarse (rms 0.024, largest error 0.19 on the thesis's table) and may lie outside
// [0, 1], down to −0.064: it is used as it is, because clamping would end its linearity. Mask 255
// is exactly 0. e(d) = e(−d), so the coefficients of order 1 are no more than noise of the fit.
#pragma once

#include <span>

#include "error/error_table.h"
#include "math/sh.h"

namespace probebake {

class ShErrorTable {
  public:
    /// Throws std::invalid_argument when the table's directions do not determine 9 coefficients.
    explicit ShErrorTable(const ErrorTable& table);

    /// In the order of sh_basis.
    std::span<const float, kShCount> coefficients(uint8_t mask) const { return rows_[mask]; }

    /// e(d, mask) for a unit direction d.
    double error(const Vec3& d, uint8_t mask) const {
        const Sh9 basis = sh_basis(d);
        double sum = 0.0;
        for (size_t i = 0; i < kShCount; ++i) sum += basis[i] * double{rows_[mask][i]};
        return sum;
    }

  private:
    std::array<std::array<float, kShCount>, kMaskCount> rows_{};
};

/// The thesis's table: cast rays, 512 × 512, 256 directions. Built at the first call (a few tenths
/// of a second), once per process, by any thread.
const ShErrorTable& thesis_error_table();

}  // namespace probebake
