#include "scatter/path_loop.h"
#include "track/decomposition.h"
#include "track/delta.h"

namespace probebake {
namespace {

template <class Tracker>
PathTracer::Instance scalar(const TrackerChoice& choice) {
    return choice.gray ? instance_of<Tracker, 1>(choice) : instance_of<Tracker, 3>(choice);
}

}  // namespace

PathTracer::Instance scalar_instance(const TrackerChoice& choice) {
    switch (choice.tracker) {
        case TrackerKind::kDelta:
            return scalar<DeltaTracker>(choice);
        case TrackerKind::kWeightedDelta:
            return scalar<WeightedDelta>(choice);
        case TrackerKind::kAnalogDecomposition:
            return scalar<AnalogDecomposition>(choice);
        case TrackerKind::kWeightedDecomposition:
            return scalar<WeightedDecomposition>(choice);
        default:
            return nullptr;
    }
}

}  // namespace probebake
