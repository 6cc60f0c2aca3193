#include "scatter/path_tracer.h"

#include "scatter/path_loop.h"

namespace probebake {
namespace {

/// Passes everything.
struct NoFlight {
    static constexpr bool kScalar = false;
    static constexpr bool kDecomposes = false;

    template <class Traits, class Line, class Random, class Collect>
    static FlightEnd fly(Line& /*line*/, Spectrum<Traits::kChannels>& /*w*/, Random& /*random*/,
                         TrackCount& /*count*/, Collect&& /*collect*/) {
        return {};
    }
};

PathTracer::Instance instance_for(const TrackerChoice& choice, bool emitters) {
    if (const auto scalar = scalar_instance(choice, emitters)) return scalar;
    if (const auto spectral = spectral_instance(choice, emitters)) return spectral;
    return trace_path<NoFlight, TrackTraits<3, false, false>, false>;
}

}  // namespace

PathCount& PathCount::operator+=(const PathCount& o) {
    paths += o.paths;
    scatterings += o.scatterings;
    flights += o.flights;
    shadows += o.shadows;
    shadow_rays += o.shadow_rays;
    steps += o.steps;
    misses += o.misses;
    faults += o.faults;
    return *this;
}

PathTracer::PathTracer(const ScatterScene& scene, const TrackerChoice& choice,
                       const PathSettings& settings)
    : scene_(scene),
      choice_(choice),
      settings_(settings),
      sky_(scene.lighting.sky),
      instance_(instance_for(choice, scene.emitters != nullptr && !scene.emitters->empty() &&
                                         scene.lighting.emission)) {}

}  // namespace probebake
