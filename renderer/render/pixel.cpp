#include "render/pixel.h"

#include <cmath>
#include <numbers>

#include "math/random.h"

namespace probebake {

Rgb PixelSums::standard_error() const {
    if (samples < 2) return Rgb(0.0f);
    const Vec3 spread = color2_weight2 - 2.0 * color * color_weight2 + color * color * weight2;
    const double bessel = samples / (samples - 1.0);
    Rgb error;
    for (int c = 0; c < 3; ++c) {
        error[c] = static_cast<float>(std::sqrt(std::max(0.0, spread[c] * bessel)));
    }
    return error;
}

PixelRay pixel_ray(const View& view, double x, double y, double pixels) {
    const Vec3 direction = view.direction(x, y);
    const double length = glm::length(direction);
    // At distance t along the ray the plane is t / length away.
    const double footprint_per_t = pixels * view.pixel_spacing() / length;
    return {{view.origin, direction / length}, std::numbers::sqrt2 * footprint_per_t};
}

PixelSums uniform_pixel(const RenderScene& scene, const View& view, int x, int y, int grid,
                        CostStats& stats, const LevelOfDetail& lod) {
    PixelSums sums;
    const double weight = 1.0 / (grid * grid);
    for (int j = 0; j < grid; ++j) {
        for (int i = 0; i < grid; ++i) {
            const PixelRay cast =
                pixel_ray(view, x - 0.5 + (i + 0.5) / grid, y - 0.5 + (j + 0.5) / grid);
            const Hit hit = trace(scene.tree, cast.ray, lod, scene.range);
            stats.keep(hit);
            sums.add(shade(scene, hit), hit.t, scene.range.t_max, weight);
        }
    }
    return sums;
}

PixelSums lod_pixel(const RenderScene& scene, const View& view, int x, int y,
                    const RenderSettings& settings, CostStats& stats) {
    const PixelRay cast = pixel_ray(view, x, y);
    const LevelOfDetail lod = settings.fixed_level
                                  ? LevelOfDetail{.fixed_level = *settings.fixed_level}
                                  : LevelOfDetail{.cone = cast.cone};
    const Hit hit = trace(scene.tree, cast.ray, lod, scene.range);
    stats.keep(hit);
    PixelSums sums;
    sums.add(shade(scene, hit), hit.t, scene.range.t_max, 1.0);
    return sums;
}

Rgb stratified_pixel(const RenderScene& scene, const View& view, int x, int y, int side,
                     RandomStream& random, CostStats& stats) {
    Vec3 sum(0.0);
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const double u = random.uniform();
            const double v = random.uniform();
            const PixelRay cast =
                pixel_ray(view, x - 0.5 + (i + u) / side, y - 0.5 + (j + v) / side);
            const Hit hit = trace(scene.tree, cast.ray, {}, scene.range);
            stats.keep(hit);
            sum += Vec3(shade(scene, hit));
        }
    }
    return Rgb(sum / static_cast<double>(side * side));
}

}  // namespace probebake
