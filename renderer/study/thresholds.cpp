#include "error/node_error.h"
#include "study/experiments.h"

namespace probebake::study {
namespace {

Outcome error_aware(double threshold, double decay) {
    return [threshold, decay](const PixelRecord& pixel) {
        return error_aware_outcome(pixel, threshold, decay);
    };
}

}  // namespace

Json run_threshold_decay(const ExperimentInput& input) {
    const RecordSet& set = input.work.nadir();
    Json result = {{"cells", Json::array()}, {"decays", Json::array()}};
    for (const double decay : kDecays) {
        for (const double threshold : kThresholds) {
            Json cell = write_counts(set.count(error_aware(threshold, decay)));
            cell["decay"] = decay;
            cell["threshold"] = threshold;
            result["cells"].push_back(std::move(cell));
        }
    }
    // As the thesis chose its decay: the threshold of each decay by an equal cost, then the error.
    const uint64_t steps = set.count(error_aware(kThesisThreshold, kThesisDecay)).steps;
    for (const double decay : kDecays) {
        const double threshold = set.threshold_for_steps(steps, decay);
        Json row = write_measured(set.measure(error_aware(threshold, decay)));
        row["decay"] = decay;
        row["threshold"] = threshold;
        result["decays"].push_back(std::move(row));
    }
    return result;
}

Json run_thresholds(const ExperimentInput& input) {
    const RecordSet& set = input.work.nadir();
    Json rows = Json::array();
    for (const double threshold : kThresholds) {
        Json row = write_measured(set.measure(error_aware(threshold, kThesisDecay)));
        row["threshold"] = threshold;
        rows.push_back(std::move(row));
    }
    return {{"rows", std::move(rows)}};
}

Json measure_equal_steps(const RecordSet& set) {
    const uint64_t base = set.count(lod_outcome).steps;
    Json rows = Json::array();
    for (const double budget : kBudgets) {
        const auto steps = static_cast<uint64_t>(budget * static_cast<double>(base));
        const double threshold = set.threshold_for_steps(steps, kThesisDecay);
        const Measured measured = set.measure(error_aware(threshold, kThesisDecay));
        Json row = {{"times_base", budget}, {"threshold", threshold}, {"base_steps", base}};
        row["error_aware"] = write_measured(measured);
        for (const MissesInKernel misses : {MissesInKernel::kLeftOut, MissesInKernel::kBlack}) {
            const double normaliser = set.normaliser_for_steps(measured.counts.steps, misses);
            row[misses == MissesInKernel::kLeftOut ? "adaptive" : "adaptive_black"] =
                write_measured(set.measure([&](const PixelRecord& pixel) {
                    return adaptive_outcome(pixel, normaliser, misses);
                }));
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

Json run_equal_steps(const ExperimentInput& input) {
    return {{"rows", measure_equal_steps(input.work.nadir())}};
}

}  // namespace probebake::study
