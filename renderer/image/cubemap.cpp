#include "image/cubemap.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace probebake {

Vec3 face_direction(CubeFace face, double u, double v) {
    switch (face) {
        case CubeFace::kPosX:
            return {1.0, -v, u};
        case CubeFace::kNegX:
            return {-1.0, -v, -u};
        case CubeFace::kPosY:
            return {u, 1.0, -v};
        case CubeFace::kNegY:
            return {u, -1.0, v};
        case CubeFace::kPosZ:
            return {-u, -v, 1.0};
        case CubeFace::kNegZ:
            return {u, -v, -1.0};
    }
    return {1.0, -v, u};
}

FacePoint face_point(const Vec3& d) {
    const double ax = std::abs(d.x);
    const double ay = std::abs(d.y);
    const double az = std::abs(d.z);
    if (ax >= ay && ax >= az) {
        return {d.x > 0 ? CubeFace::kPosX : CubeFace::kNegX, (d.x > 0 ? d.z : -d.z) / ax,
                -d.y / ax};
    }
    if (ay >= az) {
        return {d.y > 0 ? CubeFace::kPosY : CubeFace::kNegY, d.x / ay, (d.y > 0 ? -d.z : d.z) / ay};
    }
    return {d.z > 0 ? CubeFace::kPosZ : CubeFace::kNegZ, (d.z > 0 ? -d.x : d.x) / az, -d.y / az};
}

double pixel_solid_angle(int x, int y, int n) {
    // Solid angle of the rectangle from the face's centre to the corner (u, v).
    const auto corner = [](double u, double v) {
        return std::atan2(u * v, std::sqrt(u * u + v * v + 1.0));
    };
    const double half = grid_spacing(n) / 2.0;
    const double u = grid_coordinate(x, n);
    const double v = grid_coordinate(y, n);
    const double u0 = std::max(u - half, -1.0);
    const double u1 = std::min(u + half, 1.0);
    const double v0 = std::max(v - half, -1.0);
    const double v1 = std::min(v + half, 1.0);
    return corner(u1, v1) - corner(u0, v1) - corner(u1, v0) + corner(u0, v0);
}

CubePixel owner_of(const CubePixel& pixel, int n) {
    if (n == 1) return pixel;
    const int last = n - 1;
    // Twice the direction in integers, so that ties are exact: components in [−last, last].
    const int u = 2 * pixel.x - last;
    const int v = 2 * pixel.y - last;
    std::array<int, 3> d{};
    switch (pixel.face) {
        case CubeFace::kPosX:
            d = {last, -v, u};
            break;
        case CubeFace::kNegX:
            d = {-last, -v, -u};
            break;
        case CubeFace::kPosY:
            d = {u, last, -v};
            break;
        case CubeFace::kNegY:
            d = {u, -last, v};
            break;
        case CubeFace::kPosZ:
            d = {-u, -v, last};
            break;
        case CubeFace::kNegZ:
            d = {u, -v, -last};
            break;
    }
    const auto on_face = [&](CubeFace face, int at_u, int at_v) {
        return CubePixel{face, (at_u + last) / 2, (at_v + last) / 2};
    };
    if (d[0] == last) return on_face(CubeFace::kPosX, d[2], -d[1]);
    if (d[0] == -last) return on_face(CubeFace::kNegX, -d[2], -d[1]);
    if (d[1] == last) return on_face(CubeFace::kPosY, d[0], -d[2]);
    if (d[1] == -last) return on_face(CubeFace::kNegY, d[0], d[2]);
    return pixel;
}

Rgb sample_bilinear(const Cubemap& cubemap, const Vec3& direction) {
    const int n = cubemap.face_size();
    const FacePoint point = face_point(direction);
    if (n == 1) return cubemap.at({point.face, 0, 0});
    const double x = (point.u + 1.0) / 2.0 * (n - 1);
    const double y = (point.v + 1.0) / 2.0 * (n - 1);
    const int x0 = std::clamp(static_cast<int>(x), 0, n - 2);
    const int y0 = std::clamp(static_cast<int>(y), 0, n - 2);
    const auto row = [&](int at_y) {
        return glm::mix(cubemap.at({point.face, x0, at_y}), cubemap.at({point.face, x0 + 1, at_y}),
                        static_cast<float>(x - x0));
    };
    return glm::mix(row(y0), row(y0 + 1), static_cast<float>(y - y0));
}

void Cubemap::share_edges() {
    for_each_shared_pixel(
        n_, [&](const CubePixel& pixel, const CubePixel& owner) { at(pixel) = at(owner); });
}

}  // namespace probebake
