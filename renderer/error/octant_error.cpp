#include "error/octant_error.h"

#include <algorithm>
#include <cmath>

#include "error/projected_area_error.h"

namespace probebake {

OctantErrorTable::OctantErrorTable() {
    // A tenth of the values lies halfway between two steps: they all go up, whatever the last bit
    // of the exact table, or the code would lose its symmetry.
    constexpr double kHalfUp = 0.5 + 1e-9;
    for (int i = 0; i <= kCells; ++i) {
        for (int j = 0; i + j <= kCells; ++j) {
            const MaskErrors exact =
                projected_area_errors(glm::normalize(Vec3(i, j, kCells - i - j)));
            for (size_t mask = 0; mask < kMaskCount; ++mask) {
                values_[mask][static_cast<size_t>(vertex(i, j))] =
                    static_cast<uint8_t>(std::floor(kSteps * exact[mask] + kHalfUp));
            }
        }
    }
}

double OctantErrorTable::error(const Vec3& d, uint8_t mask) const {
    const std::array<uint8_t, kVertices>& values = values_[mirror_mask(mask, negative_axes(d))];
    const Vec3 size = glm::abs(d);
    const double scale = kCells / (size.x + size.y + size.z);
    const double u = scale * size.x;
    const double v = scale * size.y;
    const int i = std::min(static_cast<int>(u), kCells - 1);
    const int j = std::min(static_cast<int>(v), kCells - 1 - i);
    const double fu = u - i;
    const double fv = v - j;
    const auto value = [&](int a, int b) -> double {
        return values[static_cast<size_t>(vertex(a, b))];
    };
    const double at_u = value(i + 1, j);
    const double at_v = value(i, j + 1);
    // A cell of the last diagonal has no upper triangle, whatever rounding says.
    if (fu + fv <= 1.0 || i + j == kCells - 1) {
        const double at_0 = value(i, j);
        return (at_0 + fu * (at_u - at_0) + fv * (at_v - at_0)) / kSteps;
    }
    const double at_1 = value(i + 1, j + 1);
    return (at_1 + (1.0 - fv) * (at_u - at_1) + (1.0 - fu) * (at_v - at_1)) / kSteps;
}

}  // namespace probebake
