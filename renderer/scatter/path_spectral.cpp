#include "scatter/path_loop.h"
#include "track/spectral.h"

namespace probebake {
namespace {

/// Emission is collected at collisions, so that nothing is lost without absorption events.
template <Scheme S, bool Decompose = false>
PathTracer::Instance spectral(const TrackerChoice& choice, bool emitters) {
    return instance_of<SpectralTracker<S, Termination::kMerged, Decompose>, 3>(choice, emitters);
}

}  // namespace

PathTracer::Instance spectral_instance(const TrackerChoice& choice, bool emitters) {
    switch (choice.tracker) {
        case TrackerKind::kSpectralMax:
            return spectral<Scheme::kMax>(choice, emitters);
        case TrackerKind::kSpectralAverage:
            return spectral<Scheme::kAverage>(choice, emitters);
        case TrackerKind::kHistoryMax:
            return spectral<Scheme::kHistoryMax>(choice, emitters);
        case TrackerKind::kHistoryAverage:
            return spectral<Scheme::kHistoryAverage>(choice, emitters);
        case TrackerKind::kSpectralMaxDecomposition:
            return spectral<Scheme::kMax, true>(choice, emitters);
        case TrackerKind::kHistoryAverageDecomposition:
            return spectral<Scheme::kHistoryAverage, true>(choice, emitters);
        case TrackerKind::kSpectralMis:
            return instance_of<SpectralMis, 3>(choice, emitters);
        case TrackerKind::kClosedForm:
            return instance_of<HomogeneousMis, 3>(choice, emitters);
        default:
            return nullptr;
    }
}

}  // namespace probebake
