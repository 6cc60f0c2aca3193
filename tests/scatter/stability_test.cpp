// Stiff and extreme media: what breaks trackers, one case after the other, and that it does not.
#include "scatter/scatter_fixture.h"
#include "track/delta.h"
#include "track/media_line.h"
#include "track/spectral.h"
#include "track/spectral_mis.h"
#include "track/transmittance.h"

namespace probebake {
namespace {

using test::World;

GridShape cloud_at(const Vec3& offset, double scale = 0.5) {
    GridShape shape = test::noise_cloud();
    shape.index_to_world.linear = glm::dmat3(scale);
    shape.index_to_world.offset = offset - Vec3(12.0 * scale);
    return shape;
}

/// A furnace of radiance `sky` around a medium in equilibrium with it: the mean is the sky.
void expect_invisible(const MediumSpec& spec, double sky, const Vec3& at, double size_m) {
    World world;
    world.media = Media({spec}, {.max_depth = 5, .threshold = 0.2});
    world.lighting.sky = Sky(Rgb(static_cast<float>(sky)));
    const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
    const auto got = test::mean_radiance(tracer, 4000, 41, [&](RandomStream& random) {
        const Vec3 d = test::random_direction(random);
        return Ray{at - d * (3.0 * size_m), d};
    });
    EXPECT_GT(got.count.scatterings, 500u);
    for (int c = 0; c < 3; ++c) {
        const double exact = double{static_cast<float>(sky)};
        EXPECT_TRUE(std::isfinite(got.mean(c)));
        EXPECT_NEAR(got.mean(c) / exact, 1.0, 4.5 * got.sigma(c) / exact + 1e-9);
    }
}

TEST(Stability, FarFromTheOrigin) {
    const Vec3 far(1e6, -2e6, 3e6);
    expect_invisible({.name = "far", .scattering_per_m = Rgb(1, 2, 3), .shape = cloud_at(far)}, 1.0,
                     far, 12.0);
}

TEST(Stability, CloudsOfMillimetresAndOfThousandsOfKilometres) {
    for (const double scale : {1e-4, 1e5}) {
        const auto per_m = static_cast<float>(0.5 / scale);
        expect_invisible({.name = "scaled",
                          .scattering_per_m = Rgb(per_m, 2 * per_m, per_m),
                          .g = 0.9,
                          .shape = cloud_at(Vec3(0.0), scale)},
                         1.0, Vec3(0.0), 24.0 * scale);
    }
}

TEST(Stability, EmissionOfAnySize) {
    for (const double size : {1e-30, 1e30}) {
        expect_invisible({.name = "hot",
                          .absorption_per_m = Rgb(0.5f),
                          .scattering_per_m = Rgb(0.5f, 1.0f, 0.5f),
                          .emission = Rgb(static_cast<float>(size)),
                          .shape = cloud_at(Vec3(0.0))},
                         size, Vec3(0.0), 12.0);
    }
}

TEST(Stability, PhaseFunctionsAtTheirEnds) {
    for (const double g : {-0.9999, -1e-7, 0.0, 1e-15, 0.9999}) {
        expect_invisible(
            {.name = "g", .scattering_per_m = Rgb(1.0f), .g = g, .shape = cloud_at(Vec3(0.0))}, 1.0,
            Vec3(0.0), 12.0);
    }
}

/// Transmittance of a homogeneous box in a grid's clothes, by flights.
template <class Tracker>
std::array<Moments, 3> escape(const Media& media, const Ray& ray, int flights) {
    std::array<Moments, 3> moments;
    RandomStream random(42);
    TrackCount count;
    for (int i = 0; i < flights; ++i) {
        MediaLine<3> line(media, ray, {});
        Spectrum<3> w(1.0);
        const FlightEnd end = Tracker::template fly<TrackTraits<3, true, false>>(
            line, w, random, count, CollectNothing());
        for (int c = 0; c < 3; ++c) {
            moments[static_cast<size_t>(c)].add(end.event == Event::kEscape ? w[c] : 0.0);
        }
    }
    EXPECT_EQ(count.faults, 0u);
    return moments;
}

// 1 : 100 : 10⁴. One majorant for all leaves the thin channels nothing: the plain schemes say 0,
// without any variance that would betray it. Per-channel majorants find the truth.
TEST(Stability, ExtinctionOverFourDecades) {
    const Media media({{.name = "stiff",
                        .absorption_per_m = Rgb(0.01f, 1.0f, 100.0f),
                        .shape = HomogeneousShape{Box{{0, 0, 0}, {1, 1, 1}}}}});
    const Ray ray{{-1, 0.5, 0.5}, {1, 0, 0}};
    EXPECT_EQ(choose_tracker(facts_of(media), {.forced = TrackerKind::kSpectralMis}).tracker,
              TrackerKind::kSpectralMis);
    constexpr int kFlights = 20000;
    const auto mis = escape<SpectralMis>(media, ray, kFlights);
    for (size_t c = 0; c < 2; ++c) {
        const double exact = std::exp(c == 0 ? -double{0.01f} : -1.0);
        EXPECT_NEAR(mis[c].mean(), exact, 4.5 * std::sqrt(mis[c].variance() / kFlights));
        EXPECT_GT(mis[c].variance(), 0.0);
    }
    const auto average = escape<SpectralTracker<Scheme::kAverage>>(media, ray, kFlights);
    EXPECT_LT(average[0].mean(), 0.5);  // the failure that the choice avoids
}

// A shell 1e4 times denser than what is around it: one leaf takes hundreds of look-ups, an octree
// split where it is thick a few.
TEST(Stability, AThinShell) {
    const auto shell =
        std::make_shared<DensityGrid>(test::make_grid({0, 0, 0}, {64, 64, 64}, [](const IVec3& p) {
            const double r = glm::length(Vec3(p) - 32.0);
            return std::abs(r - 20.0) < 1.0 ? 10000.0f : 1.0f;
        }));
    const auto lookups = [&](int depth) {
        const Media media({{.name = "shell",
                            .scattering_per_m = Rgb(1e-3f),
                            .shape = GridShape{shell, {}, nullptr}}},
                          {.max_depth = depth, .threshold = 0.5});
        TrackCount count;
        for (uint64_t i = 0; i < 300; ++i) {
            RandomStream random(i);
            const Ray ray{{32.0 + 4.0 * random.uniform(), 32.0, 32.0}, {0, 1, 0}};
            MediaLine<1> line(media, ray, {});
            Spectrum<1> w(1.0);
            DeltaTracker::fly<TrackTraits<1, false, false>>(line, w, random, count,
                                                            CollectNothing());
        }
        EXPECT_EQ(count.faults, 0u);
        return static_cast<double>(count.lookups) / 300.0;
    };
    EXPECT_GT(lookups(1), 100.0);
    EXPECT_LT(lookups(8), 5.0);
}

TEST(Stability, TenThousandOpticalThicknessesTowardsTheSun) {
    const Media media(
        {{.name = "thick", .scattering_per_m = Rgb(2000.0f), .shape = cloud_at(Vec3(0.0))}},
        {.max_depth = 9, .threshold = 20.0});
    const Ray ray{{0.1, -10, 0.1}, {0, 1, 0}};
    EXPECT_GT(media.optical_depth(ray, {})[0], 4000.0);
    RandomStream random(43);
    TrackCount plain;
    TrackCount roulette;
    for (int i = 0; i < 300; ++i) {
        using Traits = TrackTraits<1, false, false>;
        MediaLine<1> a(media, ray, {});
        RatioTracking<false>::transmittance<Traits>(a, random, plain);
        MediaLine<1> b(media, ray, {});
        RatioTracking<true>::transmittance<Traits>(b, random, roulette);
    }
    EXPECT_GT(plain.lookups / 300, 100u);
    EXPECT_LT(10 * roulette.lookups, plain.lookups);
}

/// One leaf without an end whose majorant is never met.
struct Endless {
    int pieces = 1;
    bool next(Segment<1>& s) {
        s = {0.0, 1e30, {}, {Spectrum<1>(0.0), Spectrum<1>(1.0)}};
        return pieces-- > 0;
    }
    Coefficients<1> at(double) { return {}; }
};

// Something that never collides and never ends is given up and counted.
TEST(Stability, AFlightWithoutEndIsAFault) {
    Endless line;
    RandomStream random(44);
    TrackCount count;
    Spectrum<1> w(1.0);
    DeltaTracker::fly<TrackTraits<1, false, false>>(line, w, random, count, CollectNothing());
    EXPECT_EQ(count.faults, 1u);
    EXPECT_EQ(w[0], 0.0);
}

TEST(Stability, WhereNoChannelHasWeightThePathEnds) {
    RandomStream random(45);
    Spectrum<3> w({1.0, 0.0, 0.0});
    const Spectrum<3> green({0.0, 1.0, 0.0});
    EXPECT_EQ((choose_event<Scheme::kHistoryAverage, Termination::kFull>(
                  w, Spectrum<3>(), green, Spectrum<3>(), 1.0, 1.0, random)),
              Event::kAbsorb);
    EXPECT_EQ(w, Spectrum<3>());
}

// Probes on faces, edges and corners, in voxels, in worlds of one voxel and of 65,536³.
TEST(Stability, VoxelWorldsOfEverySizeAndProbesInAwkwardPlaces) {
    for (const int depth : {2, 16}) {
        VoxelCloud cloud;
        cloud.depth = depth;
        const int last = (1 << depth) - 1;
        for (const IVec3 p : {IVec3(1, 2, 1), IVec3(0, 0, 0), IVec3(last, last, last)}) {
            cloud.voxels.push_back(make_voxel(p, pack_rgb(Rgb(0.5f)), pack_rgb(Rgb(2.0f))));
            if (depth == 2) break;
        }
        World world;
        world.tree = VoxelTree::build(cloud);
        world.media = Media({{.name = "haze",
                              .scattering_per_m = Rgb(0.05f, 0.1f, 0.2f),
                              .shape = HomogeneousShape{Box{{-9, -9, -9}, {9, 9, 9}}}}});
        world.lighting.sun = Sun{.direction = {0, 1, 0}, .irradiance = Rgb(1.0f)};
        world.lighting.sky = Sky(Rgb(1.0f));
        const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
        for (const Vec3 at : {Vec3(1.5, 2.5, 1.5), Vec3(1, 2, 1), Vec3(2, 2.5, 1.5),
                              Vec3(2, 3, 1.5), Vec3(-8, 2, 1), Vec3(0, 0, 0)}) {
            const auto got = test::mean_radiance(tracer, 500, 46, [&](RandomStream& random) {
                return Ray{at, random.below(2) == 0 ? test::random_direction(random)
                                                    : test::random_axis(random)};
            });
            for (int c = 0; c < 3; ++c) {
                EXPECT_TRUE(std::isfinite(got.mean(c)));
                EXPECT_GT(got.mean(c), 0.1);
                EXPECT_LT(got.mean(c), 10.0);
            }
        }
    }
}

}  // namespace
}  // namespace probebake
