#include "render/hybrid.h"

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

}  // namespace

HybridStage hybrid_stage(const RenderScene& scene, const View& view, int x, int y, int stage) {
    const int grid = stage_grid(stage);
    const double width = 1.0 / grid;
    const double weight = width * width;
    HybridStage out;
    for (int j = 0; j < grid; ++j) {
        for (int i = 0; i < grid; ++i) {
            const PixelRay cast =
                pixel_ray(view, x - 0.5 + (i + 0.5) * width, y - 0.5 + (j + 0.5) * width, width);
            const auto [leaf, node] =
                trace_through(scene.tree, cast.ray, {.cone = cast.cone}, scene.range);
            Hit hit = leaf;  // and from here on the node that is shown, on the leaf's path
            if (hit) hit.level = shown_level(hit, cast.cone, scene.tree.depth());
            out.cost.keep(hit);
            out.level = static_cast<int8_t>(hit.level);
            const Vec3& direction = cast.ray.direction;
            const Rgb color = shade_at(scene, direction, leaf, hit.level);
            out.sums.add(color, hit.t, scene.range.t_max, weight);
            if (stage > 1) continue;
            out.node_error += weight * hit_error(scene, direction, node, kThesisDecay);
            out.child_variance += weight * child_variance(scene, hit, color);
            out.passed_contrast +=
                weight * squared_difference(shade(scene, direction, node), color);
        }
    }
    // Equal weights w: Σ w² c² = w · mean of c².
    const Vec3 variance =
        glm::max(Vec3(0.0), out.sums.color2_weight2 / weight - out.sums.color * out.sums.color);
    out.ray_variance = (variance.x + variance.y + variance.z) / 3.0;
    return out;
}

void add_evidence(PixelEvidence& evidence, int stage, const HybridStage& found) {
    const auto s = static_cast<size_t>(stage);
    evidence.ray_variance[s] = found.ray_variance;
    if (stage > 1) return;
    evidence.node_error[s] = found.node_error;
    evidence.child_variance[s] = found.child_variance;
    evidence.passed_contrast[s] = found.passed_contrast;
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

double predicted_gain(int stage, const PixelEvidence& evidence, uint64_t stage_steps) {
    return predicted_error(stage, evidence) /
           static_cast<double>(std::max<uint64_t>(stage_steps, 1));
}

bool goes_on(int stage, const PixelEvidence& evidence, uint64_t stage_steps,
             const RenderSettings& settings) {
    return has_next(stage, settings) &&
           predicted_gain(stage, evidence, stage_steps) > settings.price;
}

PixelSums hybrid_pixel(const RenderScene& scene, const View& view, int x, int y, double contrast,
                       const RenderSettings& settings, CostStats& stats) {
    PixelEvidence evidence{.contrast = contrast};
    for (int stage = 0;; ++stage) {
        const HybridStage found = hybrid_stage(scene, view, x, y, stage);
        add_evidence(evidence, stage, found);
        if (!goes_on(stage, evidence, found.cost.steps, settings)) {
            stats += found.cost;
            return found.sums;
        }
        stats.discard_all(found.cost);
    }
}

void record_stage(const RenderScene& scene, const View& view, int x, int y, HybridRecord& record,
                  CostStats& stats) {
    const int stage = record.recorded++;
    const HybridStage found = hybrid_stage(scene, view, x, y, stage);
    stats += found.cost;
    add_evidence(record.evidence, stage, found);
    record.stages[static_cast<size_t>(stage)] = {
        found.sums.color, static_cast<uint32_t>(found.cost.rays),
        static_cast<uint32_t>(found.cost.steps),
        predicted_gain(stage, record.evidence, found.cost.steps)};
}

ReplayedPixel replay_hybrid(const HybridRecord& record, const RenderSettings& settings) {
    ReplayedPixel pixel;
    for (int stage = 0;; ++stage) {
        const HybridRecord::Stage& at = record.stages[static_cast<size_t>(stage)];
        pixel.color = at.color;
        pixel.rays += at.rays;
        pixel.steps += at.steps;
        if (!has_next(stage, settings) || !(at.gain > settings.price)) return pixel;
    }
}

}  // namespace probebake
