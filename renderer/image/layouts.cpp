#include "image/layouts.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>

namespace probebake {
namespace {

/// Samples per side of a latlong pixel a quarter of a face's wide: so many meet even the smallest
/// pixels of a cubemap, those in its corners.
constexpr int kSamples = 3;

/// A pole is one point: its row holds the mean of what its pixels hold. The last column repeats the
/// first.
void join_row(Image& image, int y) {
    Vec3 sum(0.0);
    for (int x = 0; x + 1 < image.width(); ++x) sum += Vec3(image.at(x, y));
    const Rgb mean(sum / static_cast<double>(image.width() - 1));
    for (int x = 0; x < image.width(); ++x) image.at(x, y) = mean;
}

}  // namespace

Vec3 latlong_direction(double x, double y, int width_px, int height_px) {
    const double longitude = -2.0 * std::numbers::pi * (x / (width_px - 1) - 0.5);
    const double latitude = -std::numbers::pi * (y / (height_px - 1) - 0.5);
    return {std::sin(longitude) * std::cos(latitude), std::sin(latitude),
            std::cos(longitude) * std::cos(latitude)};
}

Image latlong_of(const Cubemap& cubemap) {
    const int n = cubemap.face_size();
    const int width = latlong_width(n);
    const int height = width / 2;
    const int samples = kSamples * (4 * n / width);
    Image image(width, height);
    const auto mean_at = [&](int x, int y) {
        Vec3 sum(0.0);
        for (int j = 0; j < samples; ++j) {
            for (int i = 0; i < samples; ++i) {
                const double at_x = x - 0.5 + (i + 0.5) / samples;
                const double at_y = y - 0.5 + (j + 0.5) / samples;
                sum += Vec3(sample_bilinear(cubemap, latlong_direction(at_x, at_y, width, height)));
            }
        }
        return Rgb(sum / static_cast<double>(samples * samples));
    };
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x + 1 < width; ++x) image.at(x, y) = mean_at(x, y);
        image.at(width - 1, y) = image.at(0, y);
    });
    join_row(image, 0);
    join_row(image, height - 1);
    return image;
}

Vec3 gl_direction(CubeFace face, double s, double t) {
    switch (face) {
        case CubeFace::kPosX:
            return {1.0, -t, -s};
        case CubeFace::kNegX:
            return {-1.0, -t, s};
        case CubeFace::kPosY:
            return {s, 1.0, t};
        case CubeFace::kNegY:
            return {s, -1.0, -t};
        case CubeFace::kPosZ:
            return {s, -t, 1.0};
        case CubeFace::kNegZ:
            return {-s, -t, -1.0};
    }
    return {1.0, -t, -s};
}

Image gl_face_of(const Cubemap& cubemap, CubeFace face) {
    const int n = cubemap.face_size();
    Image image(n, n);
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const double s = (2.0 * x + 1.0) / n - 1.0;
            const double t = (2.0 * y + 1.0) / n - 1.0;
            image.at(x, y) = sample_bilinear(cubemap, gl_direction(face, s, t));
        }
    }
    return image;
}

}  // namespace probebake
