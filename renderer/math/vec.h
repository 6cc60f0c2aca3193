// Vector types of the whole project: GLM under short names.
//
// Positions, directions and t are double (Vec3); colours and stored coefficients are float (Rgb).
#pragma once

#include <cmath>

#include <glm/glm.hpp>

namespace probebake {

using Vec3 = glm::dvec3;
using Vec2 = glm::dvec2;
using IVec3 = glm::ivec3;
/// Linear Rec.709 red, green, blue. Radiance in W·m⁻²·sr⁻¹ in lit states, 1 in albedo states.
using Rgb = glm::vec3;

/// Luminance of linear Rec.709 RGB (Müller 2020, 5.1.2).
inline float luminance(const Rgb& c) { return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b; }

inline bool is_finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace probebake
