#include "image/specular.h"

#include <tbb/parallel_for.h>

namespace probebake {

Cubemap specular_of(const SphereFilter& cubemap, double alpha, int face_size_px) {
    const GgxKernel kernel{static_cast<float>(alpha * alpha)};
    Cubemap out(face_size_px);
    tbb::parallel_for(0, 6 * face_size_px, [&](int row) {
        for (int x = 0; x < face_size_px; ++x) {
            const CubePixel pixel{kCubeFaces[static_cast<size_t>(row / face_size_px)], x,
                                  row % face_size_px};
            if (!(owner_of(pixel, face_size_px) == pixel)) continue;
            out.at(pixel) = Rgb(cubemap.mean(
                kernel, glm::normalize(face_direction(pixel.face, grid_coordinate(x, face_size_px),
                                                      grid_coordinate(pixel.y, face_size_px)))));
        }
    });
    out.share_edges();
    return out;
}

}  // namespace probebake
