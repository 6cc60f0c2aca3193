#include "render/hybrid.h"

#include "math/sampling.h"
#include "render/error_aware.h"

namespace probebake {
namespace {

/// The level whose node shows a hit under a cone: the coarsest of edge ≤ cone · t.
int shown_level(const Hit& hit, double cone, int depth) {
    int level = 0;
    while (level < depth && static_cast<double>(2 << level) <= cone * hit.t) ++level;
    return level;
}

bool has_next(int stage, const RenderSettings& settings) {
    return stage + 1 < kHybridStages && stage_grid(stage + 1) <= settings.leaf_grid;
}

/// Variance of the colours of a node's children, mean over R, G, B; where the scene is lit, that of
/// their albedo, as bright as the node is seen.
double child_variance(const RenderScene& scene, const Hit& hit, const Rgb& seen) {
    if (hit.level <= 0 || scene.color.empty()) return 0.0;
    Vec3 sum(0.0);
    Vec3 squares(0.0);
    const ColorRange children = child_colors(scene.tree, hit);
    for (uint32_t i = 0; i < children.count; ++i) {
        const Vec3 color(scene.color[{children.first.array, children.first.index + i}]);
        sum += color;
        squares += color * color;
    }
    const double n = children.count;
    const Vec3 variance = glm::max(Vec3(0.0), squares / n - sum * sum / (n * n));
    const double mean = (variance.x + variance.y + variance.z) / 3.0;
    if (scene.lit == nullptr) return mean;
    const double albedo = (sum.x + sum.y + sum.z) / n;
    const double radiance = static_cast<double>(seen.r) + seen.g + seen.b;
    return albedo > 0.0 ? mean * (radiance / albedo) * (radiance / albedo) : 0.0;
}

/// Mean over R, G, B.
double squared_difference(const Rgb& a, const Rgb& b) {
    const Vec3 difference = Vec3(a) - Vec3(b);
    return glm::dot(difference, difference) / 3.0;
}

/// First stage in which a pixel's rays are worth a list of their own: 0.17 of the steps and half of
/// the time of 256 rays from the root, but not of 16 (docs/decisions.md).
constexpr int kFirstListedStage = 3;
/// What the places of a pixel's rays are keyed by, besides the pixel.
constexpr uint64_t kPlaces = 0x68796272'69640000;

/// Offset from the pixel's middle, in pixels, of ray `index` of those that a stage adds.
Vec2 place_of(const HybridCast& cast, int stage, int index) {
    const int grid = stage_grid(stage);
    if (stage < 2 || !cast.switches.nested_rays) {
        const int row = index / grid;
        return Vec2((index % grid + 0.5) / grid - 0.5, (row + 0.5) / grid - 0.5);
    }
    const int before = stage == 2 ? 0 : grid * grid / 4;
    const uint64_t key =
        random_key({kPlaces, static_cast<uint64_t>(cast.x), static_cast<uint64_t>(cast.y)});
    return owen_sobol(static_cast<uint32_t>(before + index), key) - Vec2(0.5);
}

double channel_mean(const Vec3& v) { return (v.x + v.y + v.z) / 3.0; }

}  // namespace

void cast_stage(const HybridCast& cast, HybridPixel& pixel) {
    const RenderScene& scene = cast.scene;
    const int stage = ++pixel.stage;
    const int grid = stage_grid(stage);
    const int rays = cast.switches.nested_rays ? stage_rays(stage) : grid * grid;
    const double footprint_px = 1.0 / grid;
    if (!cast.switches.nested_rays) {
        CostStats replaced;
        replaced.discard_all(pixel.cost);
        pixel.cost = replaced;
        pixel.sums = {};
    }
    const StartList* from = cast.switches.start_lists ? cast.from : nullptr;
    StartList own;
    if (cast.switches.start_lists && stage >= kFirstListedStage) {
        const Beam beam = pixel_beam(cast.view, {cast.x, cast.y, cast.x, cast.y}, footprint_px);
        own = from != nullptr ? start_list(scene.tree, beam, *from) : start_list(scene.tree, beam);
        pixel.cost.steps += own.steps;
        from = &own;
    }
    double node_error = 0.0;
    double children_variance = 0.0;
    double passed_contrast = 0.0;
    for (int i = 0; i < rays; ++i) {
        const Vec2 place = place_of(cast, stage, i);
        const PixelRay ray = pixel_ray(cast.view, cast.x + place.x, cast.y + place.y, footprint_px);
        const LevelOfDetail lod{.cone = ray.cone};
        auto [leaf, node] = from != nullptr
                                ? trace_through(scene.tree, *from, ray.ray, lod, scene.range)
                                : trace_through(scene.tree, ray.ray, lod, scene.range);
        Hit hit = leaf;  // and from here on the node that is shown, on the leaf's path
        if (hit) {
            const int level = shown_level(hit, ray.cone, scene.tree.depth());
            hit.level = std::max(0, level - scene.finer_levels);
        }
        const Vec3& direction = ray.ray.direction;
        const Rgb color = shade_at(scene, direction, leaf, hit.level);
        hit.steps = leaf.steps;
        pixel.cost.keep(hit);
        pixel.sums.add(scene, color, hit.t, 1.0);
        if (stage > 1) continue;
        node_error += hit_error(scene, direction, node, kThesisDecay) / rays;
        children_variance += child_variance(scene, hit, color) / rays;
        node.steps = 0;  // of the walk that both have
        passed_contrast += squared_difference(shade(scene, direction, node), color) / rays;
        pixel.cost.steps += node.steps;
    }
    const auto s = static_cast<size_t>(stage);
    const PixelSums& sums = pixel.sums;
    const Vec3 mean = sums.color / sums.weight2;
    const Vec3 variance = sums.color2_weight2 / sums.weight2 - mean * mean;
    pixel.evidence.ray_variance[s] = channel_mean(glm::max(Vec3(0.0), variance));
    if (stage > 1) return;
    pixel.evidence.node_error[s] = node_error;
    pixel.evidence.child_variance[s] = children_variance;
    pixel.evidence.passed_contrast[s] = passed_contrast;
}

double neighbour_contrast(const std::array<Neighbour, 9>& block) {
    double sum = 0.0;
    int count = 0;
    for (size_t i = 0; i < block.size(); ++i) {
        if (i == 4 || !block[i].there) continue;
        sum += squared_difference(block[i].color, block[4].color);
        ++count;
    }
    return count == 0 ? 0.0 : sum / count;
}

double neighbour_contrast(std::span<const Neighbour> pixels, const View& view, int x, int y) {
    std::array<Neighbour, 9> block;
    for (int i = 0; i < 9; ++i) {
        const int nx = x + i % 3 - 1;
        const int ny = y + i / 3 - 1;
        if (nx < 0 || ny < 0 || nx >= view.width_px || ny >= view.height_px) continue;
        block[static_cast<size_t>(i)] = pixels[view.index(nx, ny)];
    }
    return neighbour_contrast(block);
}

double predicted_gain(int stage, const PixelEvidence& evidence) {
    if (stage + 1 >= kHybridStages) return 0.0;
    return predicted_error(stage, evidence) / stage_rays(stage + 1);
}

double expected_error(const HybridPixel& pixel) {
    // Nothing is fitted for the last stage; four times the rays err about half as much.
    if (pixel.stage < kHybridStages - 1) return predicted_error(pixel.stage, pixel.evidence);
    return 0.25 * predicted_error(kHybridStages - 2, pixel.evidence);
}

bool goes_on(int stage, const PixelEvidence& evidence, const RenderSettings& settings) {
    return has_next(stage, settings) && (stage_grid(stage) < settings.least_grid ||
                                         predicted_gain(stage, evidence) > settings.price);
}

PixelSums hybrid_pixel(const HybridCast& cast, double contrast, const RenderSettings& settings,
                       CostStats& stats) {
    HybridPixel pixel{.evidence = {.contrast = contrast}};
    do {
        cast_stage(cast, pixel);
    } while (goes_on(pixel.stage, pixel.evidence, settings));
    stats += pixel.cost;
    return pixel.sums.scaled(1.0 / pixel.sums.samples);
}

void record_stage(const HybridCast& cast, HybridRecord& record, CostStats& stats) {
    HybridPixel& pixel = record.pixel;
    cast_stage(cast, pixel);
    const auto s = static_cast<size_t>(pixel.stage);
    record.stages[s] = {pixel.sums.scaled(1.0 / pixel.sums.samples).color,
                        static_cast<uint32_t>(pixel.cost.all_rays()),
                        static_cast<uint32_t>(pixel.cost.steps),
                        predicted_gain(pixel.stage, pixel.evidence), expected_error(pixel)};
    const HybridRecord::Stage before = s > 0 ? record.stages[s - 1] : HybridRecord::Stage{};
    stats.rays += record.stages[s].rays - before.rays;
    stats.steps += record.stages[s].steps - before.steps;
}

ReplayedPixel replay_hybrid(const HybridRecord& record, const RenderSettings& settings) {
    int stage = 0;
    while (has_next(stage, settings) &&
           (stage_grid(stage) < settings.least_grid ||
            record.stages[static_cast<size_t>(stage)].gain > settings.price)) {
        ++stage;
    }
    const HybridRecord::Stage& at = record.stages[static_cast<size_t>(stage)];
    return {at.color, at.rays, at.steps, at.predicted, at.seconds};
}

}  // namespace probebake
