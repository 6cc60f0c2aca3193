#include "error/node_error.h"
#include "study/experiments.h"

namespace probebake::study {
namespace {

constexpr int kFixedLevel = 2;  // then 1 and 0: the thesis's levels

}  // namespace

Json run_resolutions(const ExperimentInput& input) {
    const Scene& scene = input.work.scene();
    const int full_px = input.work.size() / 4;
    Json rows = Json::array();
    // The normalisers of the full view hold for the smaller ones, as in the thesis.
    std::array<std::optional<double>, 2> normalisers;
    for (int px = full_px; px >= std::max(8, full_px / 8); px /= 2) {
        const View view = study_view(scene, input.work.size(), px);
        const Image truth =
            px == full_px ? input.work.nadir().truth()[0] : render_truth(albedo_of(scene), view);
        for (const bool fixed : {true, false}) {
            const RecordSet set(albedo_of(scene), view,
                                fixed ? std::optional<int>(kFixedLevel) : std::nullopt, truth);
            const Measured error_aware = set.measure([](const PixelRecord& pixel) {
                return error_aware_outcome(pixel, kThesisThreshold, kThesisDecay);
            });
            std::optional<double>& normaliser = normalisers[fixed ? 0 : 1];
            if (!normaliser) {
                normaliser =
                    set.normaliser_for_steps(error_aware.counts.steps, MissesInKernel::kLeftOut);
            }
            const Measured adaptive = set.measure([&](const PixelRecord& pixel) {
                return adaptive_outcome(pixel, *normaliser, MissesInKernel::kLeftOut);
            });
            rows.push_back({{"view_px", px},
                            {"level_of_detail", fixed ? "fixed" : "pixel"},
                            {"error_aware", write_measured(error_aware)},
                            {"adaptive", write_measured(adaptive)}});
        }
    }
    return {{"rows", std::move(rows)}};
}

Json run_probes(const ExperimentInput& input) {
    const RecordSet& set = input.work.probes();
    Json positions = Json::array();
    for (const Vec3& p : input.work.probe_positions_m()) positions.push_back({p.x, p.y, p.z});
    return {{"face_px", kProbeFace_px},
            {"positions_m", std::move(positions)},
            {"renderers", measure_renderers(set, {})},
            {"rows", measure_equal_steps(set)}};
}

}  // namespace probebake::study
