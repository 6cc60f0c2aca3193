#include "render/error_aware.h"

#include "error/node_error.h"
#include "error/sh_error.h"

namespace probebake {
namespace {

/// Centre of quadrant q of a pixel, in pixels.
Vec2 quadrant_centre(int x, int y, int q) {
    return {x - 0.25 + 0.5 * (q & 1), y - 0.25 + 0.5 * (q >> 1)};
}

struct Cast {
    PixelRay pixel;
    Hit hit;
};

/// The ray of a pixel (refinement 0) or of a quadrant (refinement 1).
Cast coarse_ray(const RenderScene& scene, const View& view, const Vec2& at, int refinement,
                const RenderSettings& settings) {
    Cast cast{pixel_ray(view, at.x, at.y, refinement == 0 ? 1.0 : 0.5), {}};
    const LevelOfDetail lod =
        settings.fixed_level
            ? LevelOfDetail{.fixed_level = std::max(0, *settings.fixed_level - refinement)}
            : LevelOfDetail{.cone = cast.pixel.cone};
    cast.hit = trace(scene.tree, cast.pixel.ray, lod, scene.range);
    return cast;
}

/// Calls visit(direction, hit) for the 2×2 leaf rays of a quadrant; with the others of the pixel
/// they form the regular 4×4 grid.
template <class Visit>
void quadrant_leaf_rays(const RenderScene& scene, const View& view, const Vec2& quadrant,
                        Visit visit) {
    for (int i = 0; i < 4; ++i) {
        const double x = quadrant.x - 0.125 + 0.25 * (i & 1);
        const double y = quadrant.y - 0.125 + 0.25 * (i >> 1);
        const Ray ray = pixel_ray(view, x, y).ray;
        visit(ray.direction, trace(scene.tree, ray, {}, scene.range));
    }
}

/// The 1 → 2×2 → 4×4 of the thesis, after the first ray.
PixelSums refine_quadrants(const RenderScene& scene, const View& view, int x, int y,
                           const RenderSettings& settings, CostStats& stats) {
    PixelSums sums;
    const double t_max = scene.range.t_max;
    for (int q = 0; q < 4; ++q) {
        const Vec2 at = quadrant_centre(x, y, q);
        Cast cast = coarse_ray(scene, view, at, 1, settings);
        const double error = hit_error(scene, cast.pixel.ray.direction, cast.hit, settings.decay);
        if (!needs_refinement(error, settings.threshold)) {
            sums.add(shade(scene, cast.pixel.ray.direction, cast.hit), cast.hit.t, t_max, 1.0 / 4);
            stats.keep(cast.hit);
            continue;
        }
        stats.discard(cast.hit);
        quadrant_leaf_rays(scene, view, at, [&](const Vec3& direction, Hit hit) {
            sums.add(shade(scene, direction, hit), hit.t, t_max, 1.0 / 16);
            stats.keep(hit);
        });
    }
    return sums;
}

/// Adds the rays of a record as PixelSums::add would have, one by one; distances are not recorded.
void add_rays(PixelSums& sums, const RefinementRecord::Rays& rays, double weight) {
    const double n = rays.rays;
    const double w2 = weight * weight * n;
    sums.color += rays.color * (weight * n);
    sums.samples += static_cast<int>(rays.rays);
    sums.weight2 += w2;
    sums.color_weight2 += rays.color * w2;
    sums.color2_weight2 += rays.square * w2;
}

void add_cost(ReplayedPixel& pixel, const RefinementRecord::Rays& rays) {
    pixel.rays += rays.rays;
    pixel.steps += rays.steps;
}

/// Sums of means, filled ray by ray.
class RaysRecorder {
  public:
    RaysRecorder(const RenderScene& scene, CostStats& stats) : scene_(scene), stats_(stats) {}
    void add(const Vec3& direction, Hit hit) {
        const Vec3 color(shade(scene_, direction, hit));
        stats_.keep(hit);
        rays_.color += color;
        rays_.square += color * color;
        rays_.steps += hit.steps;
        ++rays_.rays;
        rays_.hits += hit ? 1 : 0;
    }
    RefinementRecord::Rays means() const {
        RefinementRecord::Rays means = rays_;
        means.color /= static_cast<double>(rays_.rays);
        means.square /= static_cast<double>(rays_.rays);
        return means;
    }

  private:
    const RenderScene& scene_;
    CostStats& stats_;
    RefinementRecord::Rays rays_;
};

}  // namespace

double hit_error(const RenderScene& scene, const Vec3& direction, const Hit& hit, double decay) {
    if (hit.level <= 0) return 0.0;
    const ChildMasks masks = child_masks(scene.tree, hit);
    return node_error(thesis_error_table(), direction, masks.own,
                      std::span(masks.children).first(masks.child_count), decay);
}

FirstRay first_ray(const RenderScene& scene, const View& view, int x, int y,
                   const RenderSettings& settings) {
    Cast cast = coarse_ray(scene, view, {x, y}, 0, settings);
    const Rgb color = shade(scene, cast.pixel.ray.direction, cast.hit);
    return {cast.hit, color, hit_error(scene, cast.pixel.ray.direction, cast.hit, settings.decay)};
}

PixelSums refine_pixel(const RenderScene& scene, const View& view, int x, int y,
                       const RenderSettings& settings, CostStats& stats) {
    CostStats kept;
    PixelSums sums = refine_quadrants(scene, view, x, y, settings, kept);
    for (int grid = 8; grid <= settings.leaf_grid && sums.spread() > settings.spread; grid *= 2) {
        stats.discard_all(kept);
        kept = {};
        sums = uniform_pixel(scene, view, x, y, grid, kept);
    }
    stats += kept;
    return sums;
}

PixelSums error_aware_pixel(const RenderScene& scene, const View& view, int x, int y,
                            const RenderSettings& settings, CostStats& stats) {
    const FirstRay first = first_ray(scene, view, x, y, settings);
    if (needs_refinement(first.error, settings.threshold)) {
        stats.discard(first.hit);
        return refine_pixel(scene, view, x, y, settings, stats);
    }
    stats.keep(first.hit);
    PixelSums sums;
    sums.add(first.color, first.hit.t, scene.range.t_max, 1.0);
    return sums;
}

RefinementRecord record_refinement(const RenderScene& scene, const View& view, int x, int y,
                                   const RenderSettings& settings, CostStats& stats) {
    const auto record_cast = [&](const Vec2& at, int refinement, double& error) {
        const Cast cast = coarse_ray(scene, view, at, refinement, settings);
        error = hit_error(scene, cast.pixel.ray.direction, cast.hit, settings.decay);
        RaysRecorder recorder(scene, stats);
        recorder.add(cast.pixel.ray.direction, cast.hit);
        return recorder.means();
    };
    RefinementRecord record;
    record.first = record_cast({x, y}, 0, record.first_error);
    for (int q = 0; q < 4; ++q) {
        RefinementRecord::Quadrant& quadrant = record.quadrants[static_cast<size_t>(q)];
        quadrant.coarse = record_cast(quadrant_centre(x, y, q), 1, quadrant.error);
    }
    return record;
}

void record_leaves(const RenderScene& scene, const View& view, int x, int y, int leaf_grid,
                   RefinementRecord& record, CostStats& stats) {
    if (leaf_grid == 4) {
        for (int q = 0; q < 4; ++q) {
            RaysRecorder recorder(scene, stats);
            quadrant_leaf_rays(
                scene, view, quadrant_centre(x, y, q),
                [&](const Vec3& direction, const Hit& hit) { recorder.add(direction, hit); });
            record.quadrants[static_cast<size_t>(q)].leaves = recorder.means();
        }
        return;
    }
    RaysRecorder recorder(scene, stats);
    for_each_grid_ray(scene, view, x, y, leaf_grid, {},
                      [&](const Vec3& direction, const Hit& hit) { recorder.add(direction, hit); });
    record.grids[static_cast<size_t>(leaf_grid)] = recorder.means();
}

ReplayedPixel replay_error_aware(const RefinementRecord& record, const RenderSettings& settings) {
    ReplayedPixel pixel;
    add_cost(pixel, record.first);
    if (!needs_refinement(record.first_error, settings.threshold)) {
        pixel.color = record.first.color;
        return pixel;
    }
    PixelSums sums;
    for (const RefinementRecord::Quadrant& quadrant : record.quadrants) {
        add_cost(pixel, quadrant.coarse);
        if (!needs_refinement(quadrant.error, settings.threshold)) {
            add_rays(sums, quadrant.coarse, 1.0 / 4);
            continue;
        }
        add_cost(pixel, quadrant.leaves);
        add_rays(sums, quadrant.leaves, 1.0 / 16);
    }
    for (int grid = 8; grid <= settings.leaf_grid && sums.spread() > settings.spread; grid *= 2) {
        const RefinementRecord::Rays& finer = record.grids[static_cast<size_t>(grid)];
        add_cost(pixel, finer);
        sums = {};
        add_rays(sums, finer, 1.0 / (grid * grid));
    }
    pixel.color = sums.color;
    return pixel;
}

ReplayedPixel replay_reference(const RefinementRecord& record, int leaf_grid) {
    ReplayedPixel pixel;
    if (leaf_grid != 4) {
        const RefinementRecord::Rays& rays = record.grids[static_cast<size_t>(leaf_grid)];
        add_cost(pixel, rays);
        pixel.color = rays.color;
        return pixel;
    }
    for (const RefinementRecord::Quadrant& quadrant : record.quadrants) {
        add_cost(pixel, quadrant.leaves);
        pixel.color += quadrant.leaves.color * 0.25;
    }
    return pixel;
}

double leaf_spread(const RefinementRecord& record) {
    PixelSums sums;
    for (const RefinementRecord::Quadrant& quadrant : record.quadrants) {
        add_rays(sums, quadrant.leaves, 1.0 / 16);
    }
    return sums.spread();
}

}  // namespace probebake
