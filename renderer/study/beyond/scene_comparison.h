// One scene of the study of the default renderer.
#pragma once

#include "io/json.h"
#include "scene/scene.h"
#include "study/beyond/hybrid_set.h"

namespace probebake::study {

/// Costs that renderers are compared at, in steps of one ray per pixel at its level of detail.
inline constexpr std::array<double, 5> kBeyondBudgets = {1.5, 2.0, 3.0, 4.0, 6.0};

struct ComparisonParams {
    int size = 2048;  // of the study view
    int probes = 8;
    /// Records the parts that the renderer can do without, too, on the probes.
    bool ablation = true;
};

/// {"nadir": SET, "probes": SET, "ablation": [...], "irradiance": {...}, "time": {...}}; a SET has
/// the base steps, a row per budget, and the cost of the thesis's error.
Json compare_on_scene(const Scene& scene, const ComparisonParams& params);

/// The recorded pixels of both sets, to fit on.
std::vector<RecordedPixel> pixels_to_fit(const Scene& scene, const ComparisonParams& params);

}  // namespace probebake::study
