#include "volume_study/cloud_picture.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "volume_study/cpu_clock.h"

namespace probebake::volume_study {

PictureCost& PictureCost::operator+=(const PictureCost& o) {
    counted += o.counted;
    faults += o.faults;
    seconds += o.seconds;
    largest_weight = std::max(largest_weight, o.largest_weight);
    return *this;
}

CloudPicture render_picture(const Cloud& cloud, const PictureParams& params,
                            const PathFunction& path) {
    const Affine& map = cloud.shape.index_to_world;
    const Vec3 low = map.point(Vec3(cloud.shape.density->low()));
    const Vec3 size = map.vector(Vec3(cloud.shape.density->cells()));
    const double edge = std::max(size.x, size.y);
    const auto side = static_cast<size_t>(params.side);
    CloudPicture picture;
    picture.pixels.resize(side * side);
    std::vector<PictureCost> costs(side);
    tbb::parallel_for(size_t{0}, side, [&](size_t row) {
        PictureCost& cost = costs[row];
        const double start = cpu_seconds();
        for (size_t column = 0; column < side; ++column) {
            const size_t pixel = row * side + column;
            Vec3 sum(0.0);
            for (int i = 0; i < params.samples; ++i) {
                const uint64_t key = random_key({params.key, pixel, static_cast<uint64_t>(i)});
                RandomStream within(random_key({key, 1}));
                const double n = params.side;
                const double u = (static_cast<double>(column) + within.uniform()) / n - 0.5;
                const double v = 0.5 - (static_cast<double>(row) + within.uniform()) / n;
                const Vec3 middle = low + 0.5 * size;
                const Ray ray{{middle.x + u * edge, middle.y + v * edge, middle.z + 2.0 * size.z},
                              {0, 0, -1}};
                sum += path(ray, random_key({key, 2}), cost);
            }
            picture.pixels[pixel] = glm::clamp(sum / static_cast<double>(params.samples),
                                               Vec3(-params.clamp), Vec3(params.clamp));
        }
        cost.seconds += cpu_seconds() - start;
    });
    for (const PictureCost& cost : costs) picture.cost += cost;
    return picture;
}

double squared_error(const CloudPicture& a, const CloudPicture& r1, const CloudPicture& r2) {
    double sum = 0.0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        sum += glm::dot(a.pixels[i] - r1.pixels[i], a.pixels[i] - r2.pixels[i]) / 3.0;
    }
    return sum / static_cast<double>(a.pixels.size());
}

Image mosaic(const std::vector<std::vector<const CloudPicture*>>& rows, int side, int zoom) {
    const int tile = side * zoom;
    Image image(tile * static_cast<int>(rows.front().size()), tile * static_cast<int>(rows.size()));
    for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) {
            const auto row = static_cast<size_t>(y / tile);
            const auto column = static_cast<size_t>(x / tile);
            const int at = y % tile / zoom * side + x % tile / zoom;
            const Vec3& pixel = rows[row][column]->pixels[static_cast<size_t>(at)];
            image.at(x, y) = Rgb(glm::max(pixel, Vec3(0.0)));
        }
    }
    return image;
}

}  // namespace probebake::volume_study
