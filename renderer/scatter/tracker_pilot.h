// The part of the choice of a tracker that only measuring decides: a pilot of some 2,000 paths.
//
// The rule (track/choice.h) names a tracker; the pilot runs it and its rivals on the same rays and
// takes a rival only where variance × counted cost (leaves + look-ups × their cost) is smaller by
// kWorthwhile: smaller differences of a pilot are noise. Counts decide, never seconds. The depth of
// the octrees is found likewise, by cost alone; and whether rays go to emissive voxels.
#pragma once

#include <functional>
#include <vector>

#include "scatter/path_tracer.h"

namespace probebake {

inline constexpr double kWorthwhile = 1.5;

struct PilotParams {
    int paths = 2000;
    uint64_t key = 1;
    ChoiceParams choice;  // its lookup_cost weighs look-ups against leaves
};

struct PilotRow {
    TrackerKind tracker = TrackerKind::kNone;
    double variance = 0.0;  // of a path, mean over the channels
    double cost = 0.0;      // of a path
    double product() const { return variance * cost; }
};

struct TrackerPilot {
    TrackerChoice choice;
    std::vector<PilotRow> rows;  // the rule's tracker first; empty where it has no rival
    PathCount count;
};

/// Rays of the pilot: pure functions of their random numbers.
using PilotRay = std::function<Ray(RandomStream&)>;

/// A forced tracker has no rivals. Throws as choose_tracker.
TrackerPilot choose_by_pilot(const ScatterScene& scene, const PilotRay& ray,
                             const PilotParams& params = {});

struct DepthPilot {
    int max_depth = 1;
    std::vector<std::pair<int, double>> costs;  // depth, cost per path
    PathCount count;
};
/// Tries depths 2, 4, 6, … until one costs more than the best by a tenth or the octrees do not grow
/// any more. scene.media is not looked at.
DepthPilot choose_depth(const ScatterScene& scene, const std::vector<MediumSpec>& specs,
                        double threshold, const PilotRay& ray, const PilotParams& params = {});

struct EmitterPilot {
    bool sampled = false;  // whether rays go to emissive voxels
    uint64_t emitters = 0;
    // Variance of a path (within its pixel, mean over the channels) and its counted cost, voxel
    // steps included.
    double variance_sampled = 0.0;
    double variance_found = 0.0;  // foreseen by the paths that sample: rare hits would not be seen
    double cost_sampled = 0.0;
    double cost_found = 0.0;
    std::string reason;
    PathCount count;
};
/// Whether variance × cost is less with rays to the emitters of the scene than without, by
/// params.paths pairs of paths with the same ray.
EmitterPilot choose_emitters(const ScatterScene& scene, const TrackerChoice& choice,
                             const PilotRay& ray, const PilotParams& params = {});

}  // namespace probebake
