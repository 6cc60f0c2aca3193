#include "render/pixel.h"

#include <cmath>
#include <numbers>

#include "math/random.h"

namespace probebake {

namespace {

/// Variance of the mean, per channel.
Vec3 variance_of_mean(const PixelSums& sums) {
    if (sums.samples < 2) return Vec3(0.0);
    const Vec3 deviation = sums.color2_weight2 - 2.0 * sums.color * sums.color_weight2 +
                           sums.color * sums.color * sums.weight2;
    const double bessel = sums.samples / (sums.samples - 1.0);
    return glm::max(Vec3(0.0), deviation * bessel);
}

}  // namespace

PixelSums PixelSums::scaled(double factor) const {
    PixelSums sums = *this;
    sums.color *= factor;
    sums.distance *= factor;
    sums.squared_distance *= factor;
    sums.weight2 *= factor * factor;
    sums.color_weight2 *= factor * factor;
    sums.color2_weight2 *= factor * factor;
    return sums;
}

Rgb PixelSums::standard_error() const { return Rgb(glm::sqrt(variance_of_mean(*this))); }

double PixelSums::spread() const {
    const Vec3 variance = variance_of_mean(*this);
    return std::sqrt((variance.x + variance.y + variance.z) / 3.0);
}

PixelRay pixel_ray(const View& view, double x, double y, double pixels) {
    const Vec3 direction = view.direction(x, y);
    const double length = glm::length(direction);
    // At distance t along the ray the plane is t / length away.
    const double footprint_per_t = pixels * view.pixel_spacing() / length;
    return {{view.origin, direction / length}, std::numbers::sqrt2 * footprint_per_t};
}

Beam pixel_beam(const View& view, const PixelRect& rect, double pixels) {
    const double left = rect.x0 - 0.5;
    const double right = rect.x1 + 0.5;
    const double top = rect.y0 - 0.5;
    const double bottom = rect.y1 + 0.5;
    const double side = std::max(right - left, bottom - top) * view.pixel_spacing();
    const double middle_length =
        glm::length(view.direction(0.5 * (left + right), 0.5 * (top + bottom)));
    return {.origin = view.origin,
            .edges = {view.direction(left, top), view.direction(right, top),
                      view.direction(right, bottom), view.direction(left, bottom)},
            .width = side / middle_length,
            .cone = std::numbers::sqrt2 * pixels * view.pixel_spacing()};
}

PixelSums uniform_pixel(const RenderScene& scene, const View& view, int x, int y, int grid,
                        CostStats& stats, const LevelOfDetail& lod) {
    PixelSums sums;
    const double weight = 1.0 / (grid * grid);
    for_each_grid_ray(scene, view, x, y, grid, lod, [&](const Vec3& direction, Hit hit) {
        sums.add(shade(scene, direction, hit), hit.t, scene.range.t_max, weight);
        stats.keep(hit);
    });
    return sums;
}

PixelSums lod_pixel(const RenderScene& scene, const View& view, int x, int y,
                    const RenderSettings& settings, CostStats& stats) {
    const PixelRay cast = pixel_ray(view, x, y);
    const LevelOfDetail lod = settings.fixed_level
                                  ? LevelOfDetail{.fixed_level = *settings.fixed_level}
                                  : LevelOfDetail{.cone = cast.cone};
    Hit hit = trace(scene.tree, cast.ray, lod, scene.range);
    PixelSums sums;
    sums.add(shade(scene, cast.ray.direction, hit), hit.t, scene.range.t_max, 1.0);
    stats.keep(hit);
    return sums;
}

Rgb stratified_pixel(const RenderScene& scene, const View& view, int x, int y, int side,
                     const StartList& from, RandomStream& random, CostStats& stats) {
    Vec3 sum(0.0);
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const double u = random.uniform();
            const double v = random.uniform();
            const PixelRay cast =
                pixel_ray(view, x - 0.5 + (i + u) / side, y - 0.5 + (j + v) / side);
            Hit hit = trace(scene.tree, from, cast.ray, scene.range);
            sum += Vec3(shade(scene, cast.ray.direction, hit));
            stats.keep(hit);
        }
    }
    return Rgb(sum / static_cast<double>(side * side));
}

}  // namespace probebake
