// The cases of whole paths: media in equilibrium with the sky around them.
#include "math/random.h"
#include "scatter/path_tracer.h"
#include "volume/phase.h"
#include "volume_study/stability.h"
#include "volume_study/stability_clouds.h"

namespace probebake::volume_study {
namespace {

using Cases = std::vector<StabilityCase>;

constexpr int kPaths = 4'000;

/// Radiance of paths through a medium that nothing should be seen of: per channel the mean is
/// `sky`, over which values are divided.
struct Furnace {
    MediumSpec spec;
    double sky = 1.0;
    Vec3 middle_m{0.0};
    double size_m = 12.0;
    std::optional<TrackerKind> tracker;
};

struct Glow {
    std::array<Moments, 3> moments;  // of radiance / sky
    uint64_t faults = 0;
};

Glow glow_of(const Furnace& params) {
    const VoxelTree tree = VoxelTree::build({.depth = 2});
    const Media media({params.spec}, {.max_depth = 5, .threshold = 0.2});
    Lighting lighting;
    lighting.sky = Sky(Rgb(static_cast<float>(params.sky)));
    ChoiceParams choice;
    choice.forced = params.tracker;
    const ScatterScene scene{.tree = tree,
                             .corner_m = params.middle_m + Vec3(50.0 * params.size_m),
                             .media = media,
                             .lighting = lighting};
    const PathTracer tracer(scene, choose_tracker(facts_of(media), choice));
    Glow glow;
    PathCount count;
    for (int i = 0; i < kPaths; ++i) {
        RandomStream ray(random_key({2, static_cast<uint64_t>(i)}));
        PathRandom random(random_key({3, static_cast<uint64_t>(i)}));
        const Vec3 d = around({0, 1, 0}, 2.0 * ray.uniform() - 1.0, ray.uniform());
        const Vec3 radiance =
            tracer.trace({params.middle_m - d * (3.0 * params.size_m), d}, {}, random, count)
                .radiance;
        for (int c = 0; c < 3; ++c) {
            glow.moments[static_cast<size_t>(c)].add(radiance[c] /
                                                     double{static_cast<float>(params.sky)});
        }
    }
    glow.faults = count.all_faults();
    return glow;
}

Cases furnace(const std::string& name, const Furnace& params) {
    const Glow glow = glow_of(params);
    Cases cases;
    for (size_t c = 0; c < 3; ++c) {
        cases.push_back(
            unbiased(name, std::string("mean / truth, ") + "RGB"[c], glow.moments[c], 1.0));
    }
    cases.push_back(at_most(name, "faults", static_cast<double>(glow.faults), 0.0));
    return cases;
}

void append(Cases& all, Cases some) {
    for (StabilityCase& one : some) all.push_back(std::move(one));
}

void coloured_albedo_1(Cases& all) {
    const MediumSpec chroma{
        .name = "albedo 1", .scattering_per_m = Rgb(2.0f, 4.0f, 5.6f), .shape = lumps()};
    for (const TrackerKind tracker : {TrackerKind::kHistoryAverage, TrackerKind::kSpectralMis}) {
        append(all, furnace("albedo 1, .5 : 1 : 1.4, " + std::string(probebake::name_of(tracker)),
                            {.spec = chroma, .tracker = tracker}));
    }
    double lost = 0.0;
    double spread = 0.0;
    for (const Moments& channel :
         glow_of({.spec = chroma, .tracker = TrackerKind::kSpectralMax}).moments) {
        lost = std::max(lost, 1.0 - channel.mean());
        spread = std::max(spread, channel.variance());
    }
    const std::string loss = "albedo 1, .5 : 1 : 1.4, spectral_max";
    all.push_back(
        at_least(loss, "without the choice: share of energy lost in a channel", lost, 0.1));
    all.push_back(at_least(loss, "without the choice: largest variance", spread, 10.0));
}

void furnaces(Cases& all) {
    const auto medium = [](const Rgb& absorb, const Rgb& scatter, double emission, double g,
                           GridShape shape) {
        return MediumSpec{.name = "medium",
                          .absorption_per_m = absorb,
                          .scattering_per_m = scatter,
                          .emission = Rgb(static_cast<float>(emission)),
                          .g = g,
                          .shape = std::move(shape)};
    };
    const Rgb none(0.0f);
    for (const double emission : {1e-30, 1e30}) {
        append(all,
               furnace(std::string("emission ") + (emission < 1.0 ? "1e-30" : "1e30"),
                       {.spec = medium(Rgb(0.5f), Rgb(0.5f, 1.0f, 0.5f), emission, 0.0, lumps()),
                        .sky = emission}));
    }
    const Vec3 far(1e6, -2e6, 3e6);
    append(all,
           furnace("cloud 3.7e6 m from the origin",
                   {.spec = medium(none, Rgb(1, 2, 3), 0.0, 0.0, lumps(far)), .middle_m = far}));
    for (const double cell : {1e-4, 1e5}) {
        const auto per_m = static_cast<float>(0.5 / cell);
        append(all, furnace(cell < 1.0 ? "cloud of 2.4 mm" : "cloud of 2,400 km",
                            {.spec = medium(none, Rgb(per_m, 2 * per_m, per_m), 0.0, 0.9,
                                            lumps(Vec3(0.0), cell)),
                             .size_m = 24.0 * cell}));
    }
}

}  // namespace

std::vector<StabilityCase> furnace_cases() {
    Cases all;
    coloured_albedo_1(all);
    furnaces(all);
    return all;
}

}  // namespace probebake::volume_study
