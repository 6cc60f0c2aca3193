#include "error/error_table.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace probebake {

std::vector<Vec3> even_directions(int count) {
    if (count < 1) throw std::invalid_argument("even_directions: expected a count of at least 1");
    // Turning by the golden angle 2π(2 − φ) needs no libm: the set is the same on every machine.
    constexpr double kCosGolden = -0.73736887807831990;
    constexpr double kSinGolden = 0.67549029426152364;
    std::vector<Vec3> directions;
    directions.reserve(static_cast<size_t>(count));
    Vec2 turn(1.0, 0.0);
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / count;
        const double radius = std::sqrt(1.0 - z * z);
        directions.push_back(glm::normalize(Vec3(radius * turn.x, radius * turn.y, z)));
        turn = glm::normalize(Vec2(kCosGolden * turn.x - kSinGolden * turn.y,
                                   kSinGolden * turn.x + kCosGolden * turn.y));
    }
    return directions;
}

void require_unit(std::span<const Vec3> directions) {
    for (const Vec3& d : directions) {
        if (std::abs(glm::length(d) - 1.0) <= kUnitTolerance) continue;
        std::ostringstream message;
        message << "direction (" << d.x << ", " << d.y << ", " << d.z << "): expected unit length";
        throw std::invalid_argument(message.str());
    }
}

}  // namespace probebake
