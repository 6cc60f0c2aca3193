#include "render/view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace probebake {
namespace {

TEST(View, ACubeFaceLooksThroughTheGridOfTheCubemap) {
    for (const int n : {1, 2, 3, 16, 64}) {
        for (const CubeFace face : kCubeFaces) {
            const View view = cube_face_view(face, n, Vec3(1.0, 2.0, 3.0));
            for (int y = 0; y < n; ++y) {
                for (int x = 0; x < n; ++x) {
                    const double u = n > 1 ? grid_coordinate(x, n) : 0.0;
                    const double v = n > 1 ? grid_coordinate(y, n) : 0.0;
                    EXPECT_EQ(view.direction(x, y), face_direction(face, u, v));
                }
            }
        }
    }
    EXPECT_EQ(cube_face_view(CubeFace::kPosX, 1, {}).pixel_spacing(), 2.0);
    EXPECT_EQ(cube_face_view(CubeFace::kPosX, 65, {}).pixel_spacing(), 2.0 / 64);
}

TEST(View, APerspectiveViewSpansItsFieldOfView) {
    const View view = perspective_view({.origin = {0, 0, 0},
                                        .forward = {0, -1, 0},
                                        .up = {0, 0, -1},
                                        .vertical_fov_degrees = 90,
                                        .width_px = 512,
                                        .height_px = 512});
    const Vec3 left_edge = view.direction(-0.5, 255.5);
    EXPECT_NEAR(left_edge.x / -left_edge.y, -1.0, 1e-12);  // 45 degrees, +X to the right
    const Vec3 top_edge = view.direction(255.5, -0.5);
    EXPECT_NEAR(top_edge.z / -top_edge.y, -1.0, 1e-12);
    EXPECT_NEAR(view.pixel_spacing(), 2.0 / 512, 1e-15);
    EXPECT_THROW(perspective_view({.vertical_fov_degrees = 180}), std::invalid_argument);
    EXPECT_THROW(perspective_view({.vertical_fov_degrees = std::nan("")}), std::invalid_argument);
}

}  // namespace
}  // namespace probebake
