// ProbePlace: what is known of the place where a probe stands, or was put.
#pragma once

#include <limits>
#include <optional>

#include "math/vec.h"

namespace probebake {

/// From which share of its rays on, meeting backs of faces, a probe is no valid one: what other
/// bakers take (RTXGI's fixed rays, Unity's probe volumes).
inline constexpr double kDefaultMaxBackface = 0.25;

struct ProbePlace {
    Vec3 requested_m{0.0};
    bool moved = false;  // then it stands elsewhere than requested
    /// In a voxel; of heightmaps also below the ground.
    bool inside_geometry = false;
    /// Share of directions in which a voxel is met within one voxel's edge, 0 to 1.
    double closed_in = 0.0;
    /// Share of directions in which the back of a triangle is met first; none without triangles.
    std::optional<double> backface;
    /// To the nearest voxel: 0 in one, infinite in a world without any.
    double nearest_surface_m = std::numeric_limits<double>::infinity();
    bool valid = true;
};

/// When a place is a valid one: in the air, and by these.
struct PlaceRules {
    double max_backface = kDefaultMaxBackface;
    double max_closed_in = 1.0;

    bool pass(const ProbePlace& place) const {
        return !place.inside_geometry && place.closed_in <= max_closed_in &&
               place.backface.value_or(0.0) <= max_backface;
    }
};

}  // namespace probebake
