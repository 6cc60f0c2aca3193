#include "light/sky.h"

#include <algorithm>
#include <numbers>

namespace probebake {
namespace {

Rgb radiance_of(const Rgb& constant, const Vec3& /*direction*/, double /*turn*/) {
    return constant;
}

Rgb radiance_of(const SkyGradient& gradient, const Vec3& direction, double /*turn*/) {
    const double up = direction.y / glm::length(direction);
    if (up < 0.0) return gradient.ground;
    return glm::mix(gradient.horizon, gradient.zenith, static_cast<float>(up));
}

Rgb radiance_of(const SkyPicture& picture, const Vec3& direction, double turn) {
    const Image& image = *picture.image;
    const Vec2 at = equirect_position(direction);
    const double x = at.x + turn - std::floor(at.x + turn);
    const auto texel = [](double u, int size) {
        return std::clamp(static_cast<int>(u * size), 0, size - 1);
    };
    return image.at(texel(x, image.width()), texel(at.y, image.height())) *
           static_cast<float>(picture.scale);
}

}  // namespace

// Turning the picture from +Z towards +X moves what was in its centre to the left.
Sky::Sky(SkyPicture picture) : turn_(picture.rotation_deg / 360.0) { what_ = std::move(picture); }

Rgb Sky::radiance(const Vec3& direction) const {
    return std::visit([&](const auto& what) { return radiance_of(what, direction, turn_); }, what_);
}

bool Sky::black() const {
    const Rgb* constant = std::get_if<Rgb>(&what_);
    return constant != nullptr && *constant == Rgb(0.0f);
}

int Sky::texels() const {
    const SkyPicture* picture = std::get_if<SkyPicture>(&what_);
    return picture != nullptr ? picture->image->width() : 0;
}

Vec2 equirect_position(const Vec3& direction) {
    constexpr double kPi = std::numbers::pi;
    const double across = std::hypot(direction.x, direction.z);
    return {0.5 - std::atan2(direction.x, direction.z) / (2.0 * kPi),
            0.5 - std::atan2(direction.y, across) / kPi};
}

Vec3 equirect_direction(const Vec2& position) {
    constexpr double kPi = std::numbers::pi;
    const double longitude = (0.5 - position.x) * 2.0 * kPi;
    const double latitude = (0.5 - position.y) * kPi;
    return {std::sin(longitude) * std::cos(latitude), std::sin(latitude),
            std::cos(longitude) * std::cos(latitude)};
}

}  // namespace probebake
