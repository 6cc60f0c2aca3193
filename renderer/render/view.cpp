#include "render/view.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace probebake {

View cube_face_view(CubeFace face, int n, const Vec3& origin) {
    const Vec3 forward = face_direction(face, 0.0, 0.0);
    return {.origin = origin,
            .forward = forward,
            .right = face_direction(face, 1.0, 0.0) - forward,
            .down = face_direction(face, 0.0, 1.0) - forward,
            .width_px = n,
            .height_px = n,
            .divisor = n > 1 ? n - 1.0 : 1.0};
}

View perspective_view(const PerspectiveParams& params) {
    if (!(params.vertical_fov_degrees > 0.0 && params.vertical_fov_degrees < 180.0)) {
        throw std::invalid_argument("a field of view lies between 0 and 180 degrees");
    }
    const Vec3 forward = glm::normalize(params.forward);
    const Vec3 right = glm::normalize(glm::cross(forward, params.up));
    const double half_angle = params.vertical_fov_degrees * std::numbers::pi / 360.0;
    return {.origin = params.origin,
            .forward = forward,
            .right = right,
            .down = glm::cross(forward, right),
            .width_px = params.width_px,
            .height_px = params.height_px,
            .divisor = params.height_px / std::tan(half_angle)};
}

}  // namespace probebake
