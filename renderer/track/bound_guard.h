// Bounds that turn out not to bound: raise them and fly again (after Misso et al. 2023,
// "Progressive null-tracking for volumetric rendering").
//
// Grids have exact bounds and need none of this; procedural densities have guesses. With a majorant
// of f times the extinction, f < 1, weighted delta tracking stays unbiased with a relative variance
// of e^(τ(2−f)/f) − 1, 10⁸ at τ = 6 and f = 0.9 in multiple scattering. A line that sees more than
// its bound says by how much; the factor goes to all lines after it. What a flight met before its
// bound was raised is thrown away: the few flights until the factor has settled are biased towards
// thin places, those after it are not.
#pragma once

#include <algorithm>

#include "track/track.h"

namespace probebake {

struct BoundGuard {
    double factor = 1.0;  // on all majorants
    uint64_t raised = 0;  // flights flown again
};

/// make_line(factor) gives a line whose majorants are multiplied by the factor, with
/// `double excess() const`: the largest extinction met over its bound, at most 1 where all was
/// bounded. fly(line) flies it anew: weights set back, other random numbers.
template <class MakeLine, class Fly>
auto fly_guarded(BoundGuard& guard, MakeLine make_line, Fly fly) {
    for (;;) {
        auto line = make_line(guard.factor);
        auto result = fly(line);
        if (!(line.excess() > 1.0)) return result;
        // A tenth more, so that a smooth maximum is not crept up to.
        guard.factor *= 1.1 * line.excess();
        ++guard.raised;
    }
}

}  // namespace probebake
