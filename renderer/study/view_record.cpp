#include "study/view_record.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "render/error_aware.h"

namespace probebake::study {
namespace {

RayGroup group_of(const RefinementRecord::Rays& rays) {
    return {Rgb(rays.color), rays.steps, static_cast<uint16_t>(rays.rays),
            static_cast<uint16_t>(rays.hits)};
}

RayGroup leaf_group(const RenderScene& scene, const View& view, int x, int y, int grid) {
    CostStats stats;
    const PixelSums sums = uniform_pixel(scene, view, x, y, grid, stats);
    return {sums.mean(), static_cast<uint32_t>(stats.steps), static_cast<uint16_t>(stats.rays),
            static_cast<uint16_t>(stats.hits())};
}

PixelRecord record_pixel(const RenderScene& scene, const View& view, int x, int y,
                         const std::optional<int>& fixed_level) {
    // E_N is linear in the decay: two records give both of its terms.
    CostStats uncounted;
    RefinementRecord own =
        record_refinement(scene, view, x, y, {.decay = 0.0, .fixed_level = fixed_level}, uncounted);
    const RefinementRecord with_children =
        record_refinement(scene, view, x, y, {.decay = 1.0, .fixed_level = fixed_level}, uncounted);
    record_leaves(scene, view, x, y, 4, own, uncounted);
    PixelRecord record{.rendered = true};
    record.first = {group_of(own.first), own.first_error,
                    with_children.first_error - own.first_error};
    for (size_t q = 0; q < 4; ++q) {
        const RefinementRecord::Quadrant& quadrant = own.quadrants[q];
        record.quadrants[q] = {{group_of(quadrant.coarse), quadrant.error,
                                with_children.quadrants[q].error - quadrant.error},
                               group_of(quadrant.leaves)};
    }
    record.two_by_two = leaf_group(scene, view, x, y, 2);
    return record;
}

void keep(PixelOutcome& outcome, const RayGroup& group, double weight) {
    outcome.color += Vec3(group.color) * weight;
    outcome.kept_rays += group.rays;
    outcome.kept_hits += group.hits;
    outcome.steps += group.steps;
}

void discard(PixelOutcome& outcome, const RayGroup& group) {
    outcome.discarded_rays += group.rays;
    outcome.discarded_hits += group.hits;
    outcome.steps += group.steps;
}

void keep_four_by_four(PixelOutcome& outcome, const PixelRecord& pixel) {
    for (const auto& quadrant : pixel.quadrants) keep(outcome, quadrant.leaves, 0.25);
}

}  // namespace

ViewRecord record_view(const RenderScene& scene, const View& view, const RecordParams& params) {
    ViewRecord record{.view = view};
    record.pixels.resize(static_cast<size_t>(view.width_px) * static_cast<size_t>(view.height_px));
    std::vector<OneRayPixel> one_ray(record.pixels.size());
    tbb::parallel_for(0, view.height_px, [&](int y) {
        for (int x = 0; x < view.width_px; ++x) {
            if (!renders_pixel(params.face, x, y, view.width_px)) continue;
            PixelRecord& pixel = record.pixels[view.index(x, y)];
            pixel = record_pixel(scene, view, x, y, params.fixed_level);
            one_ray[view.index(x, y)] = {luminance(pixel.first.ray.color), true,
                                         pixel.first.ray.hits > 0};
        }
    });
    tbb::parallel_for(0, view.height_px, [&](int y) {
        for (int x = 0; x < view.width_px; ++x) {
            PixelRecord& pixel = record.pixels[view.index(x, y)];
            if (!pixel.rendered) continue;
            const auto variation = [&](MissesInKernel misses) {
                return luminance_variation(one_ray, view.width_px, view.height_px, x, y, misses);
            };
            pixel.variation = variation(MissesInKernel::kLeftOut);
            pixel.variation_black = variation(MissesInKernel::kBlack);
        }
    });
    return record;
}

Image render_truth(const RenderScene& scene, const View& view,
                   const std::optional<CubeFace>& face) {
    constexpr int kTruthGrid = 16;
    Image image(view.width_px, view.height_px);
    tbb::parallel_for(0, view.height_px, [&](int y) {
        CostStats uncounted;
        for (int x = 0; x < view.width_px; ++x) {
            if (!renders_pixel(face, x, y, view.width_px)) continue;
            image.at(x, y) = uniform_pixel(scene, view, x, y, kTruthGrid, uncounted).mean();
        }
    });
    return image;
}

PixelOutcome reference_outcome(const PixelRecord& pixel) {
    PixelOutcome outcome{.refinement = 2};
    keep_four_by_four(outcome, pixel);
    return outcome;
}

PixelOutcome lod_outcome(const PixelRecord& pixel) {
    PixelOutcome outcome;
    keep(outcome, pixel.first.ray, 1.0);
    return outcome;
}

PixelOutcome adaptive_outcome(const PixelRecord& pixel, double normaliser, MissesInKernel misses) {
    const double variation =
        misses == MissesInKernel::kLeftOut ? pixel.variation : pixel.variation_black;
    const int grid = adaptive_grid(variation, normaliser);
    if (grid == 0) return lod_outcome(pixel);
    PixelOutcome outcome{.refinement = grid / 2};
    discard(outcome, pixel.first.ray);
    if (grid == 2) {
        keep(outcome, pixel.two_by_two, 1.0);
    } else {
        keep_four_by_four(outcome, pixel);
    }
    return outcome;
}

PixelOutcome error_aware_outcome(const PixelRecord& pixel, double threshold, double decay) {
    if (!needs_refinement(pixel.first.error(decay), threshold)) return lod_outcome(pixel);
    PixelOutcome outcome{.refinement = 1};
    discard(outcome, pixel.first.ray);
    for (const PixelRecord::Quadrant& quadrant : pixel.quadrants) {
        if (!needs_refinement(quadrant.coarse.error(decay), threshold)) {
            keep(outcome, quadrant.coarse.ray, 0.25);
            continue;
        }
        discard(outcome, quadrant.coarse.ray);
        keep(outcome, quadrant.leaves, 0.25);
        outcome.refinement = 2;
    }
    return outcome;
}

void Counts::add(const PixelOutcome& outcome) {
    ++pixels;
    rays += outcome.kept_rays + outcome.discarded_rays;
    hit_rays += outcome.kept_hits + outcome.discarded_hits;
    discarded_rays += outcome.discarded_rays;
    steps += outcome.steps;
    ++classes[outcome.kept_hits == 0 ? 0 : static_cast<size_t>(outcome.refinement) + 1];
}

double Counts::rays_per_hit_pixel() const {
    const uint64_t hit_pixels = pixels - classes[0];
    return hit_pixels == 0 ? 0.0 : static_cast<double>(hit_rays) / static_cast<double>(hit_pixels);
}

}  // namespace probebake::study
