#include "scatter/tracker_pilot.h"

#include <algorithm>
#include <array>
#include <limits>
#include <sstream>

#include "math/estimate.h"

namespace probebake {
namespace {

struct Measured {
    double variance = 0.0;
    double cost = 0.0;
    PathCount count;
};

Measured measure(const PathTracer& tracer, const PilotRay& ray, const PilotParams& params) {
    Measured out;
    std::array<Moments, 3> moments;
    for (int i = 0; i < params.paths; ++i) {
        const auto index = static_cast<uint64_t>(i);
        RandomStream for_ray(random_key({params.key, index, 1}));
        PathRandom random(random_key({params.key, index, 2}));
        const PathResult path = tracer.trace(ray(for_ray), {}, random, out.count);
        for (int c = 0; c < 3; ++c) moments[static_cast<size_t>(c)].add(path.radiance[c]);
    }
    for (const Moments& m : moments) out.variance += m.variance() / 3.0;
    const auto leaves = static_cast<double>(out.count.flights.leaves + out.count.shadows.leaves);
    const auto lookups = static_cast<double>(out.count.lookups());
    out.cost = (leaves + lookups * params.choice.lookup_cost) / params.paths;
    return out;
}

std::vector<TrackerKind> rivals_of(const TrackerChoice& choice) {
    using Kind = TrackerKind;
    switch (choice.tracker) {
        case Kind::kDelta:
            return {Kind::kAnalogDecomposition};
        case Kind::kAnalogDecomposition:
            return {Kind::kDelta};
        case Kind::kHistoryAverage:
        case Kind::kHistoryAverageDecomposition:
        case Kind::kSpectralMis:
            // Delta tracking of media that are not gray: a channel at a time.
            return {Kind::kHistoryAverage, Kind::kSpectralMis, Kind::kDelta};
        default:
            return {};
    }
}

std::string short_number(double x) {
    std::ostringstream text;
    text.precision(3);
    text << x;
    return text.str();
}

/// What one path, scattering or shadow ray takes besides, and a level of the emitters' tree, in
/// steps through voxels; measured (docs/decisions.md).
constexpr double kRaySteps = 5.0;
constexpr double kLevelSteps = 0.5;

/// Everything that a path does in voxels, media and between them.
double whole_cost(const PathCount& count, const PilotParams& params) {
    return static_cast<double>(count.flights.leaves + count.shadows.leaves + count.steps) +
           static_cast<double>(count.lookups()) * params.choice.lookup_cost +
           static_cast<double>(count.paths + count.scatterings + count.shadow_rays) * kRaySteps;
}

double mean_of(const Vec3& v) { return (v.x + v.y + v.z) / 3.0; }

}  // namespace

TrackerPilot choose_by_pilot(const ScatterScene& scene, const PilotRay& ray,
                             const PilotParams& params) {
    const MediaFacts facts = facts_of(scene.media);
    TrackerPilot out;
    out.choice = choose_tracker(facts, params.choice);
    if (params.choice.forced) return out;
    std::vector<TrackerKind> kinds = rivals_of(out.choice);
    if (kinds.empty()) return out;
    kinds.insert(kinds.begin(), out.choice.tracker);
    for (size_t i = 0; i < kinds.size(); ++i) {
        if (i > 0 && kinds[i] == kinds[0]) continue;
        ChoiceParams forced = params.choice;
        forced.forced = kinds[i];
        const TrackerChoice choice = choose_tracker(facts, forced);
        const Measured got = measure(PathTracer(scene, choice), ray, params);
        out.count += got.count;
        out.rows.push_back({kinds[i], got.variance, got.cost});
    }
    const PilotRow& rule = out.rows.front();
    const PilotRow& best = *std::min_element(
        out.rows.begin(), out.rows.end(),
        [](const PilotRow& a, const PilotRow& b) { return a.product() < b.product(); });
    if (best.product() * kWorthwhile < rule.product()) {
        ChoiceParams forced = params.choice;
        forced.forced = best.tracker;
        const std::string was = out.choice.reason;
        out.choice = choose_tracker(facts, forced);
        out.choice.reason = "a pilot of " + std::to_string(params.paths) +
                            " paths: variance × cost is " +
                            short_number(best.product() / rule.product()) + " of that of " +
                            name_of(rule.tracker) + ", which the rule names because " + was;
    }
    return out;
}

DepthPilot choose_depth(const ScatterScene& scene, const std::vector<MediumSpec>& specs,
                        double threshold, const PilotRay& ray, const PilotParams& params) {
    DepthPilot out;
    double best = std::numeric_limits<double>::infinity();
    uint64_t nodes_before = 0;
    for (int depth = 2; depth <= kMaxMajorantDepth; depth += 2) {
        const Media media(specs, {.max_depth = depth, .threshold = threshold});
        uint64_t nodes = 0;
        for (const Medium& medium : media.all()) nodes += medium.octree.nodes().size();
        if (nodes == nodes_before) break;
        nodes_before = nodes;
        const ScatterScene with{scene.tree, scene.voxel_size_m, scene.corner_m, media,
                                scene.lighting};
        const PathTracer tracer(with, choose_tracker(facts_of(media), params.choice));
        const Measured got = measure(tracer, ray, params);
        const double cost = got.cost;
        out.count += got.count;
        out.costs.emplace_back(depth, cost);
        if (cost < best) {
            best = cost;
            out.max_depth = depth;
        } else if (cost > 1.1 * best) {
            break;
        }
    }
    return out;
}

EmitterPilot choose_emitters(const ScatterScene& scene, const TrackerChoice& choice,
                             const PilotRay& ray, const PilotParams& params) {
    EmitterPilot out;
    const PathTracer sampling(scene, choice);
    ScatterScene without = scene;
    without.emitters = nullptr;
    const PathTracer finding(without, choice);
    out.emitters = scene.emitters->size();
    PathCount found;
    double pairs = 0.0;
    double difference = 0.0;  // Σ of what E[emitted²] is more without samples
    for (int i = 0; i < params.paths; ++i) {
        const auto index = static_cast<uint64_t>(i);
        RandomStream for_ray(random_key({params.key, index, 1}));
        const Ray at = ray(for_ray);
        std::array<Vec3, 2> radiance;
        for (uint64_t k = 0; k < 2; ++k) {
            PathRandom random(random_key({params.key, index, 2 + k}));
            const PathResult path = sampling.trace(at, {}, random, out.count);
            radiance[k] = path.radiance;
            difference += mean_of(path.chance2 - path.emitted * path.emitted);
            PathRandom again(random_key({params.key, index, 2 + k}));
            finding.trace(at, {}, again, found);
        }
        const Vec3 d = radiance[0] - radiance[1];
        pairs += mean_of(d * d);
    }
    const double paths = 2.0 * params.paths;
    out.variance_sampled = pairs / paths;
    out.variance_found = std::max(0.0, out.variance_sampled + difference / paths);
    const double tree_steps =
        kLevelSteps * scene.emitters->levels() * static_cast<double>(out.count.scatterings);
    out.cost_sampled = (whole_cost(out.count, params) + tree_steps) / paths;
    out.cost_found = whole_cost(found, params) / paths;
    out.count += found;
    const double with = out.variance_sampled * out.cost_sampled;
    const double by_chance = out.variance_found * out.cost_found;
    out.sampled = with <= by_chance;
    out.reason = "a pilot of " + std::to_string(2 * params.paths) +
                 " paths: with rays to the emissive voxels, variance × cost is " +
                 short_number(by_chance > 0.0 ? with / by_chance : 1.0) + " of that without";
    return out;
}

}  // namespace probebake
