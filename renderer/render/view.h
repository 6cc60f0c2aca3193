// A View: the rays of a rectangle of pixels from one point.
//
// A pixel centre lies at u = (2x − (W−1)) / divisor to the right and v likewise downwards, on the
// plane at distance 1: a ray's direction is forward + u·right + v·down. A cubemap face on the EXR
// grid has divisor N−1 (centres on the cube's edges), a perspective view W / tan(fov/2). The
// footprint of a pixel is the square of side 2/divisor around its centre; for the pixels on the
// edge of a cube face it reaches half a pixel beyond the face, in the face's plane.
#pragma once

#include "image/cubemap.h"
#include "math/ray.h"

namespace probebake {

struct View {
    Vec3 origin{0.0};  // in the space that is rendered, voxels
    Vec3 forward{0.0, 0.0, -1.0};
    Vec3 right{1.0, 0.0, 0.0};
    Vec3 down{0.0, -1.0, 0.0};
    int width_px = 0;
    int height_px = 0;
    double divisor = 1.0;

    /// Side of a pixel's footprint on the plane at distance 1.
    double pixel_spacing() const { return 2.0 / divisor; }

    /// Of a pixel, where pixels are given row by row.
    size_t index(int x, int y) const {
        return static_cast<size_t>(y) * static_cast<size_t>(width_px) + static_cast<size_t>(x);
    }

    /// Unnormalised direction through pixel (x, y), offset in pixels from its centre.
    Vec3 direction(double x, double y) const {
        const double u = (2.0 * x - (width_px - 1)) / divisor;
        const double v = (2.0 * y - (height_px - 1)) / divisor;
        return forward + u * right + v * down;
    }
};

/// A face of a cubemap of n pixels per side, seen from `origin`.
View cube_face_view(CubeFace face, int n, const Vec3& origin);

/// A perspective view with pixel centres half a pixel from the border. `up` is not parallel to
/// `forward`. Throws std::invalid_argument for a field of view outside (0, 180) degrees.
struct PerspectiveParams {
    Vec3 origin{0.0};
    Vec3 forward{0.0, -1.0, 0.0};
    Vec3 up{0.0, 0.0, -1.0};
    double vertical_fov_degrees = 90.0;
    int width_px = 512;
    int height_px = 512;
};
View perspective_view(const PerspectiveParams& params);

}  // namespace probebake
