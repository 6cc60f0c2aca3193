#include "render/error_aware.h"

#include <cassert>

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

/// Calls visit(hit) for the per_side² leaf rays on the regular grid of a quadrant.
template <class Visit>
void leaf_rays(const RenderScene& scene, const View& view, const Vec2& quadrant, int per_side,
               Visit visit) {
    for (int j = 0; j < per_side; ++j) {
        for (int i = 0; i < per_side; ++i) {
            const double x = quadrant.x - 0.25 + 0.5 * (i + 0.5) / per_side;
            const double y = quadrant.y - 0.25 + 0.5 * (j + 0.5) / per_side;
            visit(trace(scene.tree, pixel_ray(view, x, y).ray, {}, scene.range));
        }
    }
}

size_t leaf_grid_index(int leaf_grid) {
    const auto at = std::find(kLeafGrids.begin(), kLeafGrids.end(), leaf_grid);
    assert(at != kLeafGrids.end());
    return static_cast<size_t>(at - kLeafGrids.begin());
}

void add(RefinementRecord::Rays& total, const RefinementRecord::Rays& part, double weight) {
    total.color += part.color * weight;
    total.steps += part.steps;
    total.rays += part.rays;
}

/// A discarded ray: cost without colour.
void add_cost(RefinementRecord::Rays& total, const RefinementRecord::Rays& part) {
    total.steps += part.steps;
    total.rays += part.rays;
}

}  // namespace

double hit_error(const RenderScene& scene, const Vec3& direction, const Hit& hit, double decay) {
    if (hit.level <= 0) return 0.0;
    const ChildMasks masks = child_masks(scene.tree, hit);
    return node_error(thesis_error_table(), direction, masks.own,
                      std::span(masks.children).first(masks.child_count), decay);
}

FirstRay first_ray(const RenderScene& scene, const View& view, int x, int y,
                   const RenderSettings& settings) {
    const Cast cast = coarse_ray(scene, view, {x, y}, 0, settings);
    return {cast.hit, shade(scene, cast.hit),
            hit_error(scene, cast.pixel.ray.direction, cast.hit, settings.decay)};
}

PixelSums refine_pixel(const RenderScene& scene, const View& view, int x, int y,
                       const RenderSettings& settings, CostStats& stats) {
    PixelSums sums;
    const double t_max = scene.range.t_max;
    const int per_side = settings.leaf_grid / 2;
    for (int q = 0; q < 4; ++q) {
        const Vec2 at = quadrant_centre(x, y, q);
        const Cast cast = coarse_ray(scene, view, at, 1, settings);
        const double error =
            hit_error(scene, cast.pixel.ray.direction, cast.hit, settings.decay);
        if (!needs_refinement(error, settings.threshold)) {
            stats.keep(cast.hit);
            sums.add(shade(scene, cast.hit), cast.hit.t, t_max, 0.25);
            continue;
        }
        stats.discard(cast.hit);
        const double weight = 0.25 / (per_side * per_side);
        leaf_rays(scene, view, at, per_side, [&](const Hit& hit) {
            stats.keep(hit);
            sums.add(shade(scene, hit), hit.t, t_max, weight);
        });
    }
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
    const auto error_of = [&](const Cast& cast) {
        return hit_error(scene, cast.pixel.ray.direction, cast.hit, settings.decay);
    };
    const auto rays_of = [&](const Cast& cast) {
        stats.keep(cast.hit);
        return RefinementRecord::Rays{Vec3(shade(scene, cast.hit)), cast.hit.steps, 1};
    };
    RefinementRecord record;
    const Cast first = coarse_ray(scene, view, {x, y}, 0, settings);
    record.first = rays_of(first);
    record.first_error = error_of(first);
    for (int q = 0; q < 4; ++q) {
        RefinementRecord::Quadrant& quadrant = record.quadrants[static_cast<size_t>(q)];
        const Cast second = coarse_ray(scene, view, quadrant_centre(x, y, q), 1, settings);
        quadrant.coarse = rays_of(second);
        quadrant.error = error_of(second);
    }
    return record;
}

void record_leaves(const RenderScene& scene, const View& view, int x, int y, int leaf_grid,
                   RefinementRecord& record, CostStats& stats) {
    const int per_side = leaf_grid / 2;
    for (int q = 0; q < 4; ++q) {
        RefinementRecord::Rays& leaves =
            record.quadrants[static_cast<size_t>(q)].leaves[leaf_grid_index(leaf_grid)];
        leaf_rays(scene, view, quadrant_centre(x, y, q), per_side, [&](const Hit& hit) {
            stats.keep(hit);
            leaves.color += Vec3(shade(scene, hit)) / static_cast<double>(per_side * per_side);
            leaves.steps += hit.steps;
            ++leaves.rays;
        });
    }
}

RefinementRecord::Rays replay(const RefinementRecord& record, double threshold, int leaf_grid) {
    if (!needs_refinement(record.first_error, threshold)) return record.first;
    RefinementRecord::Rays total;
    add_cost(total, record.first);
    for (const RefinementRecord::Quadrant& quadrant : record.quadrants) {
        if (needs_refinement(quadrant.error, threshold)) {
            add_cost(total, quadrant.coarse);
            add(total, quadrant.leaves[leaf_grid_index(leaf_grid)], 0.25);
        } else {
            add(total, quadrant.coarse, 0.25);
        }
    }
    return total;
}

RefinementRecord::Rays replay_reference(const RefinementRecord& record, int leaf_grid) {
    RefinementRecord::Rays total;
    for (const RefinementRecord::Quadrant& quadrant : record.quadrants) {
        add(total, quadrant.leaves[leaf_grid_index(leaf_grid)], 0.25);
    }
    return total;
}

}  // namespace probebake
