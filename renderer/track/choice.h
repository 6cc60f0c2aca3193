// Which tracker a job's media need, decided once, with the reasons.
//
//   1  nothing there                         none
//   2  homogeneous                           closed form
//   3  one extinction for all channels       scalar flights; albedos weigh the channels apart
//   4  largest extinction ratio ≤ 8          history-aware average, above it spectral MIS
//   5  residual share < 0.6, costly look-up  decomposition instead of delta tracking
//
// Kutz et al. 2017 and the figures in docs/decisions.md; the numbers are judgement, checked there.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volume/media.h"

namespace probebake {

enum class TrackerKind : uint8_t {
    kNone,
    kClosedForm,
    kTransmittance,  // no flights: nothing scatters
    kDelta,
    kWeightedDelta,
    kAnalogDecomposition,
    kWeightedDecomposition,
    kSpectralMax,
    kSpectralAverage,
    kHistoryMax,
    kHistoryAverage,
    kSpectralMaxDecomposition,
    kHistoryAverageDecomposition,
    kSpectralMis,
};
inline constexpr int kTrackerKinds = 14;

enum class TransmittanceKind : uint8_t {
    kClosedForm,
    kDelta,
    kRatio,
    kRatioRoulette,
    kResidualRatio
};

const char* name_of(TrackerKind kind);
const char* name_of(TransmittanceKind kind);
std::optional<TrackerKind> tracker_named(const std::string& name);

/// What is there.
struct MediaFacts {
    bool absorbs = false;
    bool scatters = false;
    bool emits = false;
    bool has_grid = false;
    bool homogeneous = true;        // no density varies
    bool gray_extinction = true;    // the channels of every medium to 1e-6
    double extinction_ratio = 1.0;  // largest over smallest channel, of any medium
    double residual_share = 1.0;    // ∫(most − least) / ∫ most over the leaves of the grids
};
MediaFacts facts_of(const Media& media);

struct TrackerChoice {
    TrackerKind tracker = TrackerKind::kNone;
    TransmittanceKind transmittance = TransmittanceKind::kClosedForm;
    bool gray = true;  // scalar flights for all channels at once
    bool absorbs = false;
    bool emits = false;
    std::string reason;
    std::vector<std::string> left_out;  // "what: why"
};

struct ChoiceParams {
    double most_ratio = 8.0;      // of history-aware average
    double most_residual = 0.6;   // of decomposition
    double lookup_cost = 1.0;     // of a look-up, in leaf steps
    double costly_lookup = 10.0;  // from which decomposition pays
    std::optional<TrackerKind> forced;
};

/// Throws std::invalid_argument where the forced tracker cannot render these media (closed form of
/// what varies, transmittance of what scatters, none of what is there).
TrackerChoice choose_tracker(const MediaFacts& facts, const ChoiceParams& params = {});

}  // namespace probebake
