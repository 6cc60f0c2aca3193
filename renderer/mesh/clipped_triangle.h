// ClippedTriangle: the part of a triangle inside a box, in double precision, with barycentric
// coordinates of the whole triangle at its corners (Sutherland and Hodgman 1974).
//
// For looks, whose last digits may be rounded; whether there is such a part at all is for
// triangle_box.h to say.
#pragma once

#include <array>
#include <cstddef>

#include "math/affine.h"

namespace probebake {

/// A point of a triangle.
struct SurfacePoint {
    Vec3 position{0.0};
    Vec3 barycentric{0.0};
};

class ClippedTriangle {
  public:
    ClippedTriangle(const std::array<Vec3, 3>& triangle, const Box& box);

    size_t size() const { return size_; }
    const SurfacePoint& operator[](size_t i) const { return corners_[i]; }
    /// Half the cross product around it: its length is the area, its direction the normal's.
    const Vec3& area() const { return area_; }
    /// Its centroid; that of its corners where it has no area. Requires size() > 0.
    SurfacePoint middle() const;

  private:
    static constexpr size_t kMostCorners = 9;

    std::array<SurfacePoint, kMostCorners> corners_;
    size_t size_ = 0;
    Vec3 area_{0.0};
};

/// The point of a triangle nearest to another (Ericson, Real-Time Collision Detection, 5.1.5); of a
/// triangle that is a segment or a point, too.
SurfacePoint nearest_point(const std::array<Vec3, 3>& triangle, const Vec3& to);

}  // namespace probebake
