#include "error/sh_error.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "error/ray_cast_error.h"

namespace probebake {
namespace {

using Matrix9 = std::array<Sh9, kShCount>;

/// Lower triangle L of a symmetric positive definite matrix L·Lᵀ, in place.
void cholesky(Matrix9& m) {
    for (size_t i = 0; i < kShCount; ++i) {
        const double diagonal = m[i][i];
        for (size_t j = 0; j <= i; ++j) {
            for (size_t k = 0; k < j; ++k) m[i][j] -= m[i][k] * m[j][k];
            if (j < i) m[i][j] /= m[j][j];
        }
        if (!(m[i][i] > 1e-10 * diagonal)) {
            throw std::invalid_argument(
                "ShErrorTable: the directions do not determine nine coefficients");
        }
        m[i][i] = std::sqrt(m[i][i]);
    }
}

/// Solves L·Lᵀ x = b.
Sh9 solve(const Matrix9& l, Sh9 b) {
    for (size_t i = 0; i < kShCount; ++i) {
        for (size_t k = 0; k < i; ++k) b[i] -= l[i][k] * b[k];
        b[i] /= l[i][i];
    }
    for (size_t i = kShCount; i-- > 0;) {
        for (size_t k = i + 1; k < kShCount; ++k) b[i] -= l[k][i] * b[k];
        b[i] /= l[i][i];
    }
    return b;
}

}  // namespace

ShErrorTable::ShErrorTable(const ErrorTable& table) {
    Matrix9 normal{};
    std::array<Sh9, kMaskCount> right_sides{};
    for (size_t n = 0; n < table.directions.size(); ++n) {
        const Sh9 basis = sh_basis(table.directions[n]);
        for (size_t i = 0; i < kShCount; ++i) {
            for (size_t j = 0; j < kShCount; ++j) normal[i][j] += basis[i] * basis[j];
            for (size_t mask = 0; mask < kMaskCount; ++mask) {
                right_sides[mask][i] += basis[i] * table.errors[n][mask];
            }
        }
    }
    cholesky(normal);
    for (size_t mask = 0; mask < kMaskCount; ++mask) {
        const Sh9 fit = solve(normal, right_sides[mask]);
        std::transform(fit.begin(), fit.end(), rows_[mask].begin(),
                       [](double x) { return static_cast<float>(x); });
    }
}

const ShErrorTable& thesis_error_table() {
    // Isolated: while it waits for the loop inside, the thread that builds the table must not pick
    // up an outer task, which might ask for this very table and wait for itself.
    static const ShErrorTable table = tbb::this_task_arena::isolate(
        [] { return ShErrorTable(ray_cast_errors(even_directions())); });
    return table;
}

}  // namespace probebake
