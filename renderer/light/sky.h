// What is seen where nothing is hit: radiance by direction, the same from every place.
//
// None, constant, a gradient, or an equirectangular picture. Pictures: +Y on top, +Z in the centre,
// -X to the right of it (OpenEXR's latlong, as preview.h shows panoramas), pixels at texel centres,
// W·m⁻²·sr⁻¹ after the scale; `rotation_deg` turns the picture about +Y, from +Z towards +X.
// Between texels the radiance is that of the nearest one, so that sums over texels are integrals.
#pragma once

#include <memory>
#include <variant>

#include "image/image.h"
#include "math/vec.h"

namespace probebake {

/// Above the horizon linear in the sine of the elevation, below it the ground's colour.
struct SkyGradient {
    Rgb zenith{0.0f};
    Rgb horizon{0.0f};
    Rgb ground{0.0f};
};

struct SkyPicture {
    std::shared_ptr<const Image> image;  // not empty
    double scale = 1.0;
    double rotation_deg = 0.0;
};

class Sky {
  public:
    /// Black.
    Sky() = default;
    explicit Sky(const Rgb& constant) : what_(constant) {}
    explicit Sky(const SkyGradient& gradient) : what_(gradient) {}
    explicit Sky(SkyPicture picture);

    /// Seen along a direction, of any length but 0.
    Rgb radiance(const Vec3& direction) const;
    bool black() const;
    /// Texels around the equator; 0 where the sky is smooth.
    int texels() const;

  private:
    std::variant<Rgb, SkyGradient, SkyPicture> what_ = Rgb(0.0f);
    double turn_ = 0.0;  // of a picture, in turns
};

/// Where in an equirectangular picture a direction lies: x from the left, y from the top, in [0,
/// 1]; and the other way round.
Vec2 equirect_position(const Vec3& direction);
Vec3 equirect_direction(const Vec2& position);

}  // namespace probebake
