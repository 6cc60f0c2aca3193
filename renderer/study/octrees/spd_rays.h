// The rays that ray tracing a scene of the Standard Procedural Databases casts.
//
// Haines's testing procedures (SPD 3.14, Readme.txt): eye rays at the corners of 512 × 512 pixels,
// trees of depth 5 (the eye ray is of depth 1), a reflected ray from every surface that reflects or
// transmits, a refracted one from every surface that transmits unless it reflects totally, and at
// every hit a ray to each light that the surface's normal, as modelled, faces. The rays do not
// depend on how they are cast: they are made once and cast with every octree.
#pragma once

#include <cstdint>
#include <vector>

#include "objects/object_octree.h"
#include "scene/nff/nff_file.h"

namespace probebake::study {

enum class SpdRayKind : uint8_t { kEye, kSecondary, kShadow };

struct SpdRay {
    Ray ray;
    TRange range;  // a shadow ray ends at its light
    SpdRayKind kind = SpdRayKind::kEye;
    /// What it meets: the closest hit; of a shadow ray, whether there is one.
    ObjectHit hit;
};

struct SpdRayParams {
    int size_px = 512;
    int max_depth = 5;
};

/// By kind, in the names of the 1999 article on grids; `used` are those that hit.
struct SpdRayCounts {
    std::array<uint64_t, 3> cast{};
    std::array<uint64_t, 3> used{};

    uint64_t all_cast() const { return cast[0] + cast[1] + cast[2]; }
    uint64_t all_used() const { return used[0] + used[1] + used[2]; }
};

/// In parallel on the calling arena; the order does not depend on the threads. Throws
/// std::invalid_argument where the scene has no view.
std::vector<SpdRay> spd_rays(const NffScene& scene, const ObjectOctree& octree,
                             const SpdRayParams& params);
SpdRayCounts count_rays(const std::vector<SpdRay>& rays);

}  // namespace probebake::study
