#include "scatter/path_loop.h"
#include "track/decomposition.h"
#include "track/delta.h"

namespace probebake {
namespace {

template <class Tracker>
PathTracer::Instance scalar(const TrackerChoice& choice, bool emitters) {
    return choice.gray ? instance_of<Tracker, 1>(choice, emitters)
                       : instance_of<Tracker, 3>(choice, emitters);
}

}  // namespace

PathTracer::Instance scalar_instance(const TrackerChoice& choice, bool emitters) {
    switch (choice.tracker) {
        case TrackerKind::kTransmittance:
            return scalar<Unscattered>(choice, emitters);
        case TrackerKind::kDelta:
            return scalar<DeltaTracker>(choice, emitters);
        case TrackerKind::kWeightedDelta:
            return scalar<WeightedDelta>(choice, emitters);
        case TrackerKind::kAnalogDecomposition:
            return scalar<AnalogDecomposition>(choice, emitters);
        case TrackerKind::kWeightedDecomposition:
            return scalar<WeightedDecomposition>(choice, emitters);
        default:
            return nullptr;
    }
}

}  // namespace probebake
