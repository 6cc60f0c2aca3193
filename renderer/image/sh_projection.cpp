#include "image/sh_projection.h"

namespace probebake {

Sh9 sh_basis(const CubePixel& pixel, int face_size_px) {
    return sh_basis(
        glm::normalize(face_direction(pixel.face, grid_coordinate(pixel.x, face_size_px),
                                      grid_coordinate(pixel.y, face_size_px))));
}

ShRgb project_sh(const Cubemap& cubemap) {
    const int n = cubemap.face_size();
    ShRgb sum{};
    for (const CubeFace face : kCubeFaces) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                const CubePixel pixel{face, x, y};
                const Vec3 weighted = Vec3(cubemap.at(pixel)) * pixel_solid_angle(x, y, n);
                const Sh9 basis = sh_basis(pixel, n);
                for (size_t i = 0; i < basis.size(); ++i) sum[i] += basis[i] * weighted;
            }
        }
    }
    return sum;
}

}  // namespace probebake
