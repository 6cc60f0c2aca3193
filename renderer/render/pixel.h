// One pixel, the unit of all renderers: its rays, their sums and what they cost.
#pragma once

#include <algorithm>
#include <array>

#include "light/face_colors.h"
#include "light/sky.h"
#include "math/random.h"
#include "render/cost_stats.h"
#include "render/render_settings.h"
#include "render/view.h"
#include "voxels/start_list.h"

namespace probebake {

/// What is rendered: a tree, the quantity shown where it is hit, and what a miss shows.
struct RenderScene {
    const VoxelTree& tree;
    const ColorLevels& color;  // empty: black wherever something is hit
    Rgb background{0.0f};
    TraceRange range;                 // voxels
    const FaceColors* lit = nullptr;  // radiance per face: takes the place of `color`
    const Sky* sky = nullptr;         // takes the place of `background`
    /// Octree levels by which the hybrid renderer shows finer nodes than a ray's footprint: 1 where
    /// shadows are sharp.
    int finer_levels = 0;
};

/// Weighted sums over the kept rays of a pixel; the weights of a finished pixel add up to 1.
struct PixelSums {
    Vec3 color{0.0};
    double distance = 0.0;          // radial, voxels; a miss counts as range.t_max
    double squared_distance = 0.0;  // voxels²
    int samples = 0;                // kept rays
    double weight2 = 0.0;           // Σw², Σw²c, Σw²c²: for the standard error of the mean
    Vec3 color_weight2{0.0};
    Vec3 color2_weight2{0.0};

    /// A kept ray's colour and distance (capped at `t_max`).
    void add(const Rgb& c, double t, double t_max, double weight) {
        const double d = std::min(t, t_max);
        color += Vec3(c) * weight;
        distance += weight * d;
        squared_distance += weight * d * d;
        ++samples;
        const double w2 = weight * weight;
        weight2 += w2;
        color_weight2 += Vec3(c) * w2;
        color2_weight2 += Vec3(c) * Vec3(c) * w2;
    }
    /// With all weights multiplied.
    PixelSums scaled(double factor) const;
    Rgb mean() const { return Rgb(color); }
    /// Standard error of `color` judged by the spread of the pixel's own rays; 0 for a single ray,
    /// which is no evidence of anything.
    Rgb standard_error() const;
    /// The same as one number: root mean square over the channels.
    double spread() const;
};

/// What a pixel comes to from recorded rays, all of them counted.
struct ReplayedPixel {
    Vec3 color{0.0};
    uint64_t rays = 0;  // kept and discarded
    uint64_t steps = 0;
};

/// What a ray of this direction shows of the hit's ancestor at octree level `level` (hit.level: the
/// node hit itself); for a miss, what lies behind the world. The steps that it takes to know are
/// added to the hit's (FaceColors::seen).
inline Rgb shade_at(const RenderScene& scene, const Vec3& direction, Hit& hit, int level) {
    if (!hit) return scene.sky != nullptr ? scene.sky->radiance(direction) : scene.background;
    if (scene.lit != nullptr) return scene.lit->seen(scene.tree, direction, hit, level, hit.steps);
    if (scene.color.empty()) return Rgb(0.0f);
    return scene.color[color_index(scene.tree, hit, level)];
}

/// The same of the node hit.
inline Rgb shade(const RenderScene& scene, const Vec3& direction, Hit& hit) {
    return shade_at(scene, direction, hit, hit.level);
}
/// The same, uncounted.
inline Rgb shade(const RenderScene& scene, const Vec3& direction, Hit&& hit) {
    return shade(scene, direction, hit);
}

/// A ray through a pixel and its cone: the largest node edge per distance that the footprint
/// `pixels` wide may show as one node. The node's edge is at most √2 footprints, which rounds the
/// level to the nearest one (Müller 2020, 5.1.3).
struct PixelRay {
    Ray ray;
    double cone = 0.0;
};
PixelRay pixel_ray(const View& view, double x, double y, double pixels = 1.0);

/// A rectangle of pixels, ends included.
struct PixelRect {
    int x0 = 0;
    int y0 = 0;
    int x1 = 0;
    int y1 = 0;
};
/// The beam through the footprints of some pixels, for rays of footprints up to `pixels` wide.
Beam pixel_beam(const View& view, const PixelRect& rect, double pixels);

/// Calls visit(direction, hit) for grid × grid rays on the regular grid of the pixel's footprint.
template <class Visit>
void for_each_grid_ray(const RenderScene& scene, const View& view, int x, int y, int grid,
                       const LevelOfDetail& lod, Visit visit) {
    for (int j = 0; j < grid; ++j) {
        for (int i = 0; i < grid; ++i) {
            const PixelRay cast =
                pixel_ray(view, x - 0.5 + (i + 0.5) / grid, y - 0.5 + (j + 0.5) / grid);
            visit(cast.ray.direction, trace(scene.tree, cast.ray, lod, scene.range));
        }
    }
}

/// grid × grid rays on the regular grid of the footprint, stopping at `lod` (leaves by default).
PixelSums uniform_pixel(const RenderScene& scene, const View& view, int x, int y, int grid,
                        CostStats& stats, const LevelOfDetail& lod = {});

/// One ray at the level of detail of the pixel, or at settings.fixed_level.
PixelSums lod_pixel(const RenderScene& scene, const View& view, int x, int y,
                    const RenderSettings& settings, CostStats& stats);

/// The mean of side × side leaf rays, one uniform in each cell: an unbiased estimate of the truth,
/// the mean leaf-level radiance over the footprint. `from`: the start list of the pixel's beam.
/// Rays and their steps are counted in `stats`.
Rgb stratified_pixel(const RenderScene& scene, const View& view, int x, int y, int side,
                     const StartList& from, RandomStream& random, CostStats& stats);

}  // namespace probebake
