#include "scatter/path_loop.h"
#include "track/spectral.h"

namespace probebake {
namespace {

/// Emission is collected at collisions, so that nothing is lost without absorption events.
template <Scheme S, bool Decompose = false>
PathTracer::Instance spectral(const TrackerChoice& choice) {
    return instance_of<SpectralTracker<S, Termination::kMerged, Decompose>, 3>(choice);
}

}  // namespace

PathTracer::Instance spectral_instance(const TrackerChoice& choice) {
    switch (choice.tracker) {
        case TrackerKind::kSpectralMax:
            return spectral<Scheme::kMax>(choice);
        case TrackerKind::kSpectralAverage:
            return spectral<Scheme::kAverage>(choice);
        case TrackerKind::kHistoryMax:
            return spectral<Scheme::kHistoryMax>(choice);
        case TrackerKind::kHistoryAverage:
            return spectral<Scheme::kHistoryAverage>(choice);
        case TrackerKind::kSpectralMaxDecomposition:
            return spectral<Scheme::kMax, true>(choice);
        case TrackerKind::kHistoryAverageDecomposition:
            return spectral<Scheme::kHistoryAverage, true>(choice);
        case TrackerKind::kSpectralMis:
            return instance_of<SpectralMis, 3>(choice);
        case TrackerKind::kClosedForm:
            return instance_of<HomogeneousMis, 3>(choice);
        default:
            return nullptr;
    }
}

}  // namespace probebake
