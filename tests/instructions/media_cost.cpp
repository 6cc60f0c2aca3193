// What check_media_cost.py counts the instructions of: one cloud, flown by the instance that a gray
// medium without absorption and emission gets, and by the one that can do everything.
//
//   media_cost leaf|rays|flights|paths gray|general|full NUMBER DEPTH
//
// leaf     flights through one leaf of a ramp, no grid, no octree
// rays     the rays of the two below, drawn and nothing else
// flights  rays at the cloud, each to its first collision or out of it: line, octree, look-ups
// paths    whole paths under sun and sky, over an empty world
//
// gray: delta tracking of the gray instance. general: history-aware average in three channels with
// absorption and emission, in the same gray medium. full: the same instance in a medium that
// absorbs, in colour, and emits by a grid of its own; extinction is that of the others, and so are
// leaves and candidates.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "scatter/path_loop.h"
#include "scene/generators/cumulus.h"
#include "track/delta.h"
#include "track/spectral.h"

namespace probebake {
namespace {

constexpr int kCells = 64;

struct Gray {
    using Tracker = DeltaTracker;
    using Traits = TrackTraits<1, false, false>;
};
struct General {
    using Tracker = SpectralTracker<Scheme::kHistoryAverage, Termination::kMerged>;
    using Traits = TrackTraits<3, true, true>;
};

Media cloud(bool full, int depth) {
    const auto density = std::make_shared<DensityGrid>(make_cumulus({.size = kCells}));
    MediumSpec spec{.name = "cloud", .scattering_per_m = Rgb(0.5f)};
    spec.shape = GridShape{density, {}, full ? density : nullptr};
    if (full) {
        spec.absorption_per_m = Rgb(0.125f, 0.0625f, 0.03125f);
        spec.scattering_per_m = Rgb(0.5f) - spec.absorption_per_m;
        spec.emission = Rgb(1.0f, 0.5f, 0.25f);
    }
    return Media({spec}, {.max_depth = depth, .threshold = 0.1});
}

Ray ray_at_cloud(RandomStream& random) {
    const double x = random.uniform();
    const double y = random.uniform();
    const double z = random.uniform();
    const Vec3 target = double{kCells} * (Vec3(0.5) + 0.3 * (Vec3(x, y, z) - 0.5));
    const double cosine = 2.0 * random.uniform() - 1.0;
    const Vec3 direction = around({0, 1, 0}, cosine, random.uniform());
    return {target - direction * (2.0 * kCells), direction};
}

/// One leaf in which density rises from 0 to a hundredth of its bound.
template <int N>
class RampLine {
  public:
    static constexpr int kChannels = N;

    bool next(Segment<N>& segment) {
        segment = {0.0, 1.0, {}, {Spectrum<N>(0.0), Spectrum<N>(20.0)}};
        return pieces_-- > 0;
    }
    Coefficients<N> at(double t) { return {Spectrum<N>(0.0), Spectrum<N>(0.2 * t)}; }

  private:
    int pieces_ = 1;
};

template <class Instance, class MakeLine, class Emitted>
void fly(int number, MakeLine make_line, Emitted emitted) {
    using Traits = typename Instance::Traits;
    TrackCount count;
    double sum = 0.0;
    for (int i = 0; i < number; ++i) {
        RandomStream random(random_key({1, static_cast<uint64_t>(i)}));
        auto line = make_line(random);
        Spectrum<Traits::kChannels> w(1.0);
        const auto collect = [&](double t, const auto& weight) {
            if constexpr (Traits::kEmits) sum += (weight * emitted(line, t)).sum();
        };
        sum += Instance::Tracker::template fly<Traits>(line, w, random, count, collect).t;
    }
    const double n = number;
    std::printf("%.3f lookups, %.3f leaves (%g)\n", static_cast<double>(count.lookups) / n,
                static_cast<double>(count.leaves) / n, sum);
}

/// What the others' rays cost, which is no part of an instance.
void draw_rays(int number) {
    double sum = 0.0;
    for (int i = 0; i < number; ++i) {
        RandomStream random(random_key({1, static_cast<uint64_t>(i)}));
        sum += ray_at_cloud(random).origin.x;
    }
    std::printf("0 lookups, 0 leaves (%g)\n", sum);
}

template <class Instance>
void paths(const Media& media, int number) {
    const VoxelTree tree = VoxelTree::build({.depth = 2});
    Lighting lighting;
    lighting.sun =
        Sun{.direction = {0.5, 0.7, 0.4}, .irradiance = Rgb(20.0f), .angular_diameter_deg = 0.53};
    lighting.sky = Sky(Rgb(1.0f));
    const PathTracer tracer({tree, 1.0, Vec3(1e4), media, lighting},
                            choose_tracker(facts_of(media)));
    PathCount count;
    double sum = 0.0;
    for (int i = 0; i < number; ++i) {
        RandomStream for_ray(random_key({2, static_cast<uint64_t>(i)}));
        PathRandom random(random_key({3, static_cast<uint64_t>(i)}));
        sum += trace_path<typename Instance::Tracker, typename Instance::Traits, false>(
                   tracer, ray_at_cloud(for_ray), {}, random, count)
                   .radiance.x;
    }
    const double n = number;
    std::printf("%.3f lookups, %.3f leaves, %.3f scatterings (%g)\n",
                static_cast<double>(count.lookups()) / n,
                static_cast<double>(count.flights.leaves + count.shadows.leaves) / n,
                static_cast<double>(count.scatterings) / n, sum);
}

template <class Instance>
void run(const std::string& what, bool full, int number, int depth) {
    constexpr int N = Instance::Traits::kChannels;
    if (what == "leaf") {
        fly<Instance>(
            number, [](RandomStream&) { return RampLine<N>(); },
            [](const RampLine<N>&, double) { return Spectrum<N>(); });
        return;
    }
    const Media media = cloud(full, depth);
    if (what == "rays") {
        draw_rays(number);
        return;
    }
    if (what == "paths") {
        paths<Instance>(media, number);
        return;
    }
    fly<Instance>(
        number, [&](RandomStream& random) { return MediaLine<N>(media, ray_at_cloud(random), {}); },
        [](const MediaLine<N>& line, double t) { return line.emitted_per_m(t); });
}

}  // namespace
}  // namespace probebake

int main(int argc, char** argv) {
    if (argc != 5) return 2;
    const std::string instance = argv[2];
    const int number = std::atoi(argv[3]);
    const int depth = std::atoi(argv[4]);
    if (instance == "gray") {
        probebake::run<probebake::Gray>(argv[1], false, number, depth);
    } else {
        probebake::run<probebake::General>(argv[1], instance == "full", number, depth);
    }
    return 0;
}
