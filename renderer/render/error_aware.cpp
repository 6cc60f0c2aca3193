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

struct Probe {
    PixelRay cast;
    Hit hit;
};

/// The ray of a pixel (refinement 0) or of a quadrant (refinement 1).
Probe coarse_ray(const RenderScene& scene, const View& view, const Vec2& at, int refinement,
                 const RenderSettings& settings) {
    Probe probe{pixel_ray(view, at.x, at.y, refinement == 0 ? 1.0 : 0.5), {}};
    const LevelOfDetail lod =
        settings.fixed_level
            ? LevelOfDetail{.fixed_level = std::max(0, *settings.fixed_level - refinement)}
            : LevelOfDetail{.cone = probe.cast.cone};
    probe.hit = trace(scene.tree, probe.cast.ray, lod, scene.range);
    return probe;
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

PixelSums error_aware_pixel(const RenderScene& scene, const View& view, int x, int y,
                            const RenderSettings& settings, CostStats& stats) {
    PixelSums sums;
    const double t_max = scene.range.t_max;
    const auto too_coarse = [&](const Probe& probe) {
        return needs_refinement(
            hit_error(scene, probe.cast.ray.direction, probe.hit, settings.decay),
            settings.threshold);
    };
    const Probe first = coarse_ray(scene, view, {x, y}, 0, settings);
    if (!too_coarse(first)) {
        stats.keep(first.hit);
        sums.add(shade(scene, first.hit), first.hit.t, t_max, 1.0);
        return sums;
    }
    stats.discard(first.hit);
    const int per_side = settings.leaf_grid / 2;
    for (int q = 0; q < 4; ++q) {
        const Vec2 at = quadrant_centre(x, y, q);
        const Probe second = coarse_ray(scene, view, at, 1, settings);
        if (!too_coarse(second)) {
            stats.keep(second.hit);
            sums.add(shade(scene, second.hit), second.hit.t, t_max, 0.25);
            continue;
        }
        stats.discard(second.hit);
        const double weight = 0.25 / (per_side * per_side);
        leaf_rays(scene, view, at, per_side, [&](const Hit& hit) {
            stats.keep(hit);
            sums.add(shade(scene, hit), hit.t, t_max, weight);
        });
    }
    return sums;
}

RefinementRecord record_refinement(const RenderScene& scene, const View& view, int x, int y,
                                   const RenderSettings& settings, int max_leaf_grid,
                                   CostStats& stats) {
    const auto coarse = [&](const Probe& probe) {
        stats.keep(probe.hit);
        return RefinementRecord::Rays{Vec3(shade(scene, probe.hit)), probe.hit.steps, 1};
    };
    RefinementRecord record;
    const Probe first = coarse_ray(scene, view, {x, y}, 0, settings);
    record.first = coarse(first);
    record.first_error = hit_error(scene, first.cast.ray.direction, first.hit, settings.decay);
    for (int q = 0; q < 4; ++q) {
        const Vec2 at = quadrant_centre(x, y, q);
        RefinementRecord::Quadrant& quadrant = record.quadrants[static_cast<size_t>(q)];
        const Probe second = coarse_ray(scene, view, at, 1, settings);
        quadrant.coarse = coarse(second);
        quadrant.error = hit_error(scene, second.cast.ray.direction, second.hit, settings.decay);
        for (size_t g = 0; g < kLeafGrids.size() && kLeafGrids[g] <= max_leaf_grid; ++g) {
            const int per_side = kLeafGrids[g] / 2;
            RefinementRecord::Rays& leaves = quadrant.leaves[g];
            leaf_rays(scene, view, at, per_side, [&](const Hit& hit) {
                stats.keep(hit);
                leaves.color += Vec3(shade(scene, hit)) / static_cast<double>(per_side * per_side);
                leaves.steps += hit.steps;
                ++leaves.rays;
            });
        }
    }
    return record;
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
