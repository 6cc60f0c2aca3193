// Rays to emissive voxels against finding them by scattering, against an exact case, and with their
// light counted twice.
#include <map>
#include <numbers>

#include "scatter/scatter_fixture.h"
#include "scatter/tracker_pilot.h"
#include "volume/phase.h"

namespace probebake {
namespace {

using test::World;

/// A world with its sampler of emissive voxels.
struct EmissiveWorld {
    explicit EmissiveWorld(const VoxelCloud& cloud)
        : world{.tree = VoxelTree::build(cloud)}, emitters(world.tree) {}

    ScatterScene scene(bool sampled) const {
        ScatterScene scene = world.scene();
        scene.emitters = sampled ? &emitters : nullptr;
        return scene;
    }

    World world;
    EmitterSampler emitters;
};

/// Voxels of which `emissive` shine, in colours and powers that differ a thousandfold.
VoxelCloud scattered_voxels(int count, int emissive, uint64_t seed) {
    VoxelCloud cloud;
    cloud.depth = 5;
    RandomStream random(seed);
    for (int i = 0; i < count; ++i) {
        const auto at = [&] { return static_cast<int>(random.below(32)); };
        const IVec3 place(at(), at(), at());
        Rgb light(0.0f);
        if (i < emissive) {
            const double power = std::pow(10.0, 3.0 * random.uniform() - 1.0);
            for (int c = 0; c < 3; ++c) light[c] = static_cast<float>(power * random.uniform());
        }
        cloud.voxels.push_back(make_voxel(place, pack_rgb(Rgb(0.5f)), pack_rgb(light)));
    }
    return cloud;
}

TEST(EmitterSampler, DensitiesAreThoseOfTheSamples) {
    const VoxelTree tree = VoxelTree::build(scattered_voxels(400, 60, 1));
    const EmitterSampler sampler(tree);
    ASSERT_GT(sampler.size(), 50u);
    EXPECT_EQ(sampler.found(), sampler.size());
    EXPECT_EQ(sampler.levels(), 6);
    constexpr int kSamples = 40000;
    for (const Vec3& from : {Vec3(5.3, 7.1, 20.9), Vec3(-30, 100, 14), Vec3(16.0)}) {
        RandomStream random(2);
        std::map<std::pair<uint32_t, CubeFace>, int> counts;
        int none = 0;
        for (int i = 0; i < kSamples; ++i) {
            const double u = random.uniform();
            const double v = random.uniform();
            const auto sample = sampler.sample(from, {u, v, random.uniform()});
            if (!sample) {
                ++none;
                continue;
            }
            const uint32_t voxel = *tree.find_voxel(sample->corner);
            ASSERT_NEAR(sampler.probability(from, voxel, sample->face), sample->probability, 1e-12);
            ++counts[{voxel, sample->face}];
        }
        // The probabilities of all faces sum to 1 and are the frequencies.
        double sum = 0.0;
        double chi2 = 0.0;
        int cells = 0;
        for (uint32_t voxel = 0; voxel < tree.voxel_count(); ++voxel) {
            for (const CubeFace face : kCubeFaces) {
                const double expected = kSamples * sampler.probability(from, voxel, face);
                sum += expected;
                if (expected < 5.0) continue;
                const double off = counts[{voxel, face}] - expected;
                chi2 += off * off / expected;
                ++cells;
            }
        }
        EXPECT_NEAR(sum + none, kSamples, 1e-6 * kSamples);
        EXPECT_EQ(none, 0);
        EXPECT_GT(cells, 10);
        EXPECT_LT(chi2, cells + 4.0 * std::sqrt(2.0 * cells));
    }
}

TEST(EmitterSampler, KeepsWhatIsExposedAndLooksAtThePoint) {
    VoxelCloud cloud;
    cloud.depth = 3;
    const auto add = [&](const IVec3& at, float light) {
        cloud.voxels.push_back(make_voxel(at, pack_rgb(Rgb(0.5f)), pack_rgb(Rgb(light))));
    };
    // A lamp in a socket that leaves its lower face free, and one that is buried.
    add({2, 4, 2}, 3.0f);
    for (const IVec3& off :
         {IVec3(1, 0, 0), IVec3(-1, 0, 0), IVec3(0, 1, 0), IVec3(0, 0, 1), IVec3(0, 0, -1)}) {
        add(IVec3(2, 4, 2) + off, 0.0f);
    }
    const EmitterSampler sampler(VoxelTree::build(cloud));
    ASSERT_EQ(sampler.size(), 1u);
    const auto below = sampler.sample({2.0, 1.0, 5.0}, {0.3, 0.25, 0.5});
    ASSERT_TRUE(below);
    EXPECT_EQ(below->face, CubeFace::kNegY);
    EXPECT_EQ(below->probability, 1.0);
    EXPECT_EQ(below->point, Vec3(2.5, 4.0, 2.25));
    EXPECT_FALSE(sampler.sample({2.0, 7.0, 2.0}, {0.3, 0.2, 0.5}));
    EXPECT_TRUE(EmitterSampler(VoxelTree::build(test::flat_ground(3, Rgb(0.5f)))).empty());
    EXPECT_FALSE(EmitterSampler(VoxelTree()).sample({0, 0, 0}, {0.3, 0.2, 0.5}));
}

/// Means of one number per path: radiance, and radiance with the light of emitters counted twice.
struct Means {
    Moments radiance;
    Moments doubled;
    double largest = 0.0;
    PathCount count;
};

template <class MakeRay>
Means measure(const PathTracer& tracer, int paths, uint64_t seed, MakeRay make_ray) {
    Means out;
    const auto luminance = [](const Vec3& v) { return 0.25 * v.r + 0.5 * v.g + 0.25 * v.b; };
    for (int i = 0; i < paths; ++i) {
        RandomStream for_ray(random_key({seed, static_cast<uint64_t>(i), 1}));
        PathRandom random(random_key({seed, static_cast<uint64_t>(i)}));
        const PathResult path = tracer.trace(make_ray(for_ray), {}, random, out.count);
        out.radiance.add(luminance(path.radiance));
        out.doubled.add(luminance(path.radiance + path.emitted));
        out.largest = std::max(out.largest, luminance(path.radiance));
    }
    EXPECT_EQ(out.count.all_faults(), 0u);
    return out;
}

double squared_error_of(const Moments& m) { return m.variance() / static_cast<double>(m.count()); }

double z_of(const Moments& a, const Moments& b) {
    return (a.mean() - b.mean()) / std::sqrt(squared_error_of(a) + squared_error_of(b));
}

Media medium_of(uint64_t seed) {
    RandomStream random(seed);
    const bool gray = seed % 2 == 0;
    MediumSpec spec{.name = "m", .g = 0.8 * random.uniform()};
    for (int c = 0; c < 3; ++c) {
        spec.scattering_per_m[c] = gray ? 0.08f : 0.03f * static_cast<float>(c + 1);
        spec.absorption_per_m[c] = static_cast<float>(0.01 * random.uniform());
    }
    if (gray) spec.absorption_per_m = Rgb(0.01f);
    if (seed % 3 == 0) {
        spec.shape = HomogeneousShape{Box{{-5, -5, -5}, {37, 37, 37}}};
    } else {
        spec.scattering_per_m *= 4.0f;
        GridShape shape = test::noise_cloud(seed);
        shape.index_to_world.linear = glm::dmat3(1.5);
        shape.index_to_world.offset = Vec3(-2.0);
        spec.shape = std::move(shape);
    }
    return Media({spec}, {.max_depth = 4, .threshold = 0.5});
}

/// z of sampled against found in worlds of all sorts; doubled: with emitters' light counted twice.
struct Scores {
    Moments z2;
    double largest = 0.0;
    Moments doubled_z2;

    static double rms(const Moments& squares) { return std::sqrt(squares.mean()); }
};

TEST(Emitters, RaysToThemAndChanceAgree) {
    constexpr int kPaths = 6000;
    Scores scores;
    const std::array<TrackerKind, 4> kinds = {TrackerKind::kDelta, TrackerKind::kHistoryAverage,
                                              TrackerKind::kSpectralMis,
                                              TrackerKind::kWeightedDecomposition};
    for (uint64_t seed = 1; seed <= 24; ++seed) {
        EmissiveWorld w(scattered_voxels(300, 40 + static_cast<int>(seed) * 10, seed));
        w.world.media = medium_of(seed);
        w.world.lighting.sky = Sky(Rgb(0.1f));
        const auto choice = test::forced(w.world.media, kinds[seed % kinds.size()]);
        const auto ray = [](RandomStream& random) {
            const double x = 4.0 + 24.0 * random.uniform();
            const double z = 4.0 + 24.0 * random.uniform();
            return Ray{{x, 16.0, z}, around({0, 1, 0}, 2.0 * random.uniform() - 1.0, 0.3)};
        };
        const PathTracer sampling(w.scene(true), choice);
        const PathTracer finding(w.scene(false), choice);
        const Means sampled = measure(sampling, kPaths, 2 * seed, ray);
        const Means found = measure(finding, kPaths, 2 * seed + 1, ray);
        const double z = z_of(sampled.radiance, found.radiance);
        scores.z2.add(z * z);
        scores.largest = std::max(scores.largest, std::abs(z));
        const double doubled = z_of(sampled.doubled, found.radiance);
        scores.doubled_z2.add(doubled * doubled);
        EXPECT_GT(sampled.count.shadow_rays, found.count.shadow_rays);
    }
    // 24 squared normals: their root mean square lies within these bars in 99.9 %.
    EXPECT_GT(Scores::rms(scores.z2), 0.55);
    EXPECT_LT(Scores::rms(scores.z2), 1.48);
    EXPECT_LT(scores.largest, 4.0);
    // What these bars can see: light counted twice.
    EXPECT_GT(Scores::rms(scores.doubled_z2), 4.0);
}

/// Solid angle of a rectangle of half sides a, b, a height h above its middle.
double solid_angle(double a, double b, double h) {
    return 4.0 * std::asin(a * b / std::sqrt((a * a + h * h) * (b * b + h * h)));
}

// A speck of medium above a glowing plate: what it scatters is albedo × (1 − e^−τ) × L Ω / 4π.
TEST(Emitters, ASpeckOfMediumShowsThePlateBelowIt) {
    VoxelCloud cloud;
    cloud.depth = 5;
    for (int z = 12; z < 20; ++z) {
        for (int x = 8; x < 24; ++x) {
            cloud.voxels.push_back(make_voxel({x, 0, z}, pack_rgb(Rgb(0.0f)), pack_rgb(Rgb(2.0f))));
        }
    }
    constexpr double kAlbedo = 1.0 / 1024.0;  // a second scattering adds a thousandth
    constexpr double kThin = 1e-6;            // so thin that nothing is lost on the way down
    for (const double height : {0.25, 3.0, 14.0}) {
        EmissiveWorld w(cloud);
        const Vec3 middle(16.0, 1.0 + height, 16.0);
        const Vec3 half(0.005, kThin, 0.005);
        w.world.media = Media({{.name = "speck",
                                .absorption_per_m = Rgb(static_cast<float>(100.0 * (1 - kAlbedo))),
                                .scattering_per_m = Rgb(static_cast<float>(100.0 * kAlbedo)),
                                .shape = HomogeneousShape{Box{middle - half, middle + half}}}});
        const Ray ray{middle - Vec3(5, 0, 0), {1, 0, 0}};
        const double exact = kAlbedo * (1.0 - std::exp(-1.0)) * 2.0 *
                             solid_angle(8.0, 4.0, height) / (4.0 * std::numbers::pi);
        SCOPED_TRACE(testing::Message() << "height " << height);
        for (const TrackerKind kind : {TrackerKind::kClosedForm, TrackerKind::kDelta}) {
            const PathTracer tracer(w.scene(true), test::forced(w.world.media, kind));
            const Means got = measure(tracer, 30000, 5, [&](RandomStream&) { return ray; });
            const double sigma = std::sqrt(squared_error_of(got.radiance));
            EXPECT_NEAR(got.radiance.mean(), exact, 4.0 * sigma + 0.002 * exact);
            EXPECT_LT(sigma, 0.012 * exact);  // so that 5 % would be seen
            EXPECT_GT(got.doubled.mean(), 1.5 * exact);
        }
    }
}

TEST(Emitters, CloseOnesMakeNoFireflies) {
    VoxelCloud cloud;
    cloud.depth = 5;
    test::add_box(cloud, {0, 0, 0}, {32, 1, 32}, Rgb(0.0f));
    for (int i = 0; i < 8; ++i) {
        cloud.voxels.push_back(
            make_voxel({4 * i, 1, 4 * i}, pack_rgb(Rgb(0.0f)), pack_rgb(Rgb(1.0f))));
    }
    EmissiveWorld w(cloud);
    w.world.media = Media({{.name = "fog",
                            .absorption_per_m = Rgb(0.5f),
                            .scattering_per_m = Rgb(0.5f),
                            .g = 0.7,
                            .shape = HomogeneousShape{Box{{0, 0, 0}, {32, 32, 32}}}}});
    const auto ray = [](RandomStream& random) {
        return Ray{{16.5 + random.uniform(), 2.0, 14.0}, {0, 0, 1}};
    };
    const auto choice = test::forced(w.world.media, TrackerKind::kDelta);
    const Means sampled = measure(PathTracer(w.scene(true), choice), 20000, 6, ray);
    const Means found = measure(PathTracer(w.scene(false), choice), 20000, 7, ray);
    // Every scattering adds at most its throughput × 1, and throughputs halve.
    EXPECT_LE(sampled.largest, 2.0);
    EXPECT_LT(sampled.radiance.variance(), found.radiance.variance());
    EXPECT_LT(std::abs(z_of(sampled.radiance, found.radiance)), 4.0);
}

TEST(Emitters, ThePilotForeseesWhatChanceWouldCost) {
    EmissiveWorld w(scattered_voxels(300, 12, 3));
    w.world.media = medium_of(2);
    const auto choice = test::forced(w.world.media, TrackerKind::kDelta);
    const PilotRay ray = [](RandomStream& random) {
        return Ray{{16.0, 16.0, 16.0}, around({0, 1, 0}, 2.0 * random.uniform() - 1.0, 0.1)};
    };
    const EmitterPilot few = choose_emitters(w.scene(true), choice, ray);
    EXPECT_TRUE(few.sampled) << few.reason;
    EXPECT_EQ(few.emitters, w.emitters.size());
    EXPECT_GT(few.cost_sampled, few.cost_found);
    // The variance that is foreseen, against the one of many paths without samples.
    const PathTracer finding(w.scene(false), choice);
    Moments halved;
    PathCount count;
    for (uint64_t i = 0; i < 40000; ++i) {
        RandomStream for_ray(random_key({8, i}));
        const Ray at = ray(for_ray);
        PathRandom a(random_key({9, i}));
        PathRandom b(random_key({10, i}));
        const Vec3 d =
            finding.trace(at, {}, a, count).radiance - finding.trace(at, {}, b, count).radiance;
        halved.add(glm::dot(d, d) / 6.0);
    }
    EXPECT_NEAR(few.variance_found, halved.mean(), 0.4 * halved.mean());
    // A room that glows all over is met by any scattering.
    VoxelCloud room;
    room.depth = 5;
    test::add_room(room, {0, 0, 0}, {32, 32, 32});
    for (Voxel& voxel : room.voxels) voxel.emission = pack_rgb(Rgb(1.0f));
    EmissiveWorld glowing(room);
    glowing.world.media = medium_of(2);
    const EmitterPilot all = choose_emitters(glowing.scene(true), choice, ray);
    EXPECT_FALSE(all.sampled) << all.reason;
}

}  // namespace
}  // namespace probebake
