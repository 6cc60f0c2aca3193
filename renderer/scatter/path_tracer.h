// Volumetric path tracing: radiance along one ray through media, with a voxel world as the opaque
// surface in and behind them.
//
//   L = ∫ T (μa L_e + μs ∫ p L dω) dt + T L_surface     (radiative transfer; W·m⁻²·sr⁻¹)
//
// Distances by the tracker of the plan (track/choice.h). At every scattering one shadow ray to the
// sun, one to a picture of a sky, and in media one to an emissive voxel where the scene has a
// sampler of them, both weighed against the phase function (balance heuristic); smooth skies, and
// emissive voxels without a sampler, are found by scattering. A medium's emission is collected at
// every collision candidate. Absorption weighs the path; roulette ends it below
// Settings::roulette_below. Where nothing scatters there are no flights: paths pass the media,
// weighed by the transmittance.
//
// Surfaces are Lambert: emission + albedo / π × what arrives straight or scattered from sun and
// sky. As in every renderer here, light from one surface straight to another is left out
// (docs/conventions.md, "Light"); scattered in between, it is there.
//
// Every path is a pure function of ray and random numbers; what it cost is added to counters.
#pragma once

#include "light/lighting.h"
#include "scatter/emitter_sampler.h"
#include "scatter/path_random.h"
#include "scatter/sky_sampler.h"
#include "track/choice.h"
#include "track/track.h"
#include "voxels/voxel_tree.h"

namespace probebake {

/// What paths run through. Voxel (0, 0, 0) of the tree has its corner at corner_m.
struct ScatterScene {
    const VoxelTree& tree;
    double voxel_size_m = 1.0;
    Vec3 corner_m{0.0};
    const Media& media;
    const Lighting& lighting;
    ShadowSettings shadow;                     // of rays to sun and sky
    const EmitterSampler* emitters = nullptr;  // of the tree; none: scattering alone finds them
};

struct PathSettings {
    /// Paths whose largest throughput is below this go on with probability throughput / this.
    double roulette_below = 0.25;
    int roulette_from = 4;  // scatterings
    /// Scatterings beyond which a path is given up and counted as a fault.
    int most_scatterings = 1'000'000;
};

struct PathCount {
    uint64_t paths = 0;
    uint64_t scatterings = 0;  // in media and at surfaces
    TrackCount flights;
    TrackCount shadows;  // of transmittances
    uint64_t shadow_rays = 0;
    uint64_t steps = 0;   // of all voxel rays, as CostStats counts them
    uint64_t misses = 0;  // paths that met neither medium nor voxel
    uint64_t faults = 0;

    PathCount& operator+=(const PathCount& o);
    uint64_t lookups() const { return flights.lookups + shadows.lookups; }
    uint64_t all_faults() const { return faults + flights.faults + shadows.faults; }
    bool operator==(const PathCount&) const = default;
};

struct PathResult {
    Vec3 radiance{0.0};
    /// Where the first scattering or surface is, m; infinite for the sky.
    double distance_m = std::numeric_limits<double>::infinity();
    /// The part of the radiance that scattering brings from emissive voxels.
    Vec3 emitted{0.0};
    /// Estimates the second moment that `emitted` would have if scattering alone found them.
    Vec3 chance2{0.0};
};

class PathTracer {
  public:
    /// Keeps references to the scene's parts. The choice is that of the scene's media.
    PathTracer(const ScatterScene& scene, const TrackerChoice& choice,
               const PathSettings& settings = {});

    /// `ray_m`: unit direction, metres. Surfaces nearer than range.begin are passed through, beyond
    /// range.end there is the sky; media are there in between.
    PathResult trace(const Ray& ray_m, const TRange& range, PathRandom& random,
                     PathCount& count) const {
        return instance_(*this, ray_m, range, random, count);
    }

    const ScatterScene& scene() const { return scene_; }
    const TrackerChoice& choice() const { return choice_; }
    const PathSettings& settings() const { return settings_; }
    const SkySampler& sky() const { return sky_; }

    using Instance = PathResult (*)(const PathTracer&, const Ray&, const TRange&, PathRandom&,
                                    PathCount&);

  private:
    ScatterScene scene_;
    TrackerChoice choice_;
    PathSettings settings_;
    SkySampler sky_;
    Instance instance_;
};

/// The instance of the path loop that a choice needs; one function per tracker and traits, defined
/// in path_scalar.cpp and path_spectral.cpp.
PathTracer::Instance scalar_instance(const TrackerChoice& choice, bool emitters);
PathTracer::Instance spectral_instance(const TrackerChoice& choice, bool emitters);

}  // namespace probebake
