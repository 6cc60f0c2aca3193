// One scene through all octrees: what they count and what they take.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/json.h"
#include "scene/nff/nff_file.h"

namespace probebake::study {

struct MeasureParams {
    int size_px = 512;
    std::vector<int> depths{4, 5, 6, 7};
};

/// {"objects", "box", "rays": {"cast", "used"}, "disagreements", "changed_hits", "rows":
/// [{"method", "depth", "counts": {…}, "tests", "steps", "leaves", "empty_leaves", "build_seconds",
/// "trace_seconds"}]}.
///
/// Every ray is cast with every method at every depth. "disagreements" counts the rays for which
/// the walks of one tree did not return the same object at the same distance; "changed_hits" those
/// for which a tree with the boxes of 1999 returns something else than one with boxes that lose
/// nothing. Counts do not depend on threads; seconds are CPU time, methods of a tree taking turns.
Json measure_scene(const NffScene& scene, const MeasureParams& params,
                   const std::function<void(const std::string& what)>& on_progress);

}  // namespace probebake::study
