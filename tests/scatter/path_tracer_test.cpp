#include "scatter/path_tracer.h"

#include <numbers>

#include "scatter/scatter_fixture.h"
#include "volume/phase.h"

namespace probebake {
namespace {

using test::expect_mean;
using test::World;

constexpr double kPi = std::numbers::pi;

Media thin_haze(float per_m) {
    return Media({{.name = "haze",
                   .scattering_per_m = Rgb(per_m),
                   .shape = HomogeneousShape{Box{{-1e4, -1e4, -1e4}, {1e4, 1e4, 1e4}}}}});
}

World ground(Media media) {
    World world;
    world.tree = VoxelTree::build(test::flat_ground(6, Rgb(0.25f, 0.5f, 0.75f)));
    world.media = std::move(media);
    world.corner_m = {-32.0, 0.0, -32.0};
    return world;
}

const auto kStraightDown = [](RandomStream& random) {
    return Ray{{random.uniform() * 10.0, 5.0, random.uniform() * 10.0}, {0.0, -1.0, 0.0}};
};

// With hardly any medium, surfaces show what the lighting stage gives them.
TEST(PathTracer, SurfacesShowTheLightOfTheLightingStage) {
    World world = ground(thin_haze(1e-9f));
    world.lighting.sun = Sun{
        .direction = {1, 2, 0.5}, .irradiance = Rgb(3.0f, 2.0f, 1.0f), .angular_diameter_deg = 0.5};
    auto image = std::make_shared<Image>(64, 32);
    RandomStream random(1);
    for (Rgb& pixel : image->pixels()) pixel = Rgb(static_cast<float>(random.uniform()));
    image->at(20, 8) = Rgb(200.0f, 100.0f, 50.0f);  // something bright
    for (const Sky& sky : {Sky(SkyGradient{Rgb(1, 2, 3), Rgb(2.0f), Rgb(9.0f)}),
                           Sky(SkyPicture{image, 0.5, 77.0}), Sky()}) {
        world.lighting.sky = sky;
        const LitScene lit =
            test::light(world.tree, world.lighting, {.sun_rays = 64, .sky_rays = 256});
        const Rgb expected =
            test::radiance_of(world.tree, lit.colors, {32, 0, 32}, CubeFace::kPosY);
        const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
        const auto got = test::mean_radiance(tracer, 20000, 2, kStraightDown);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(got.mean(c), double{expected[c]},
                        4.0 * got.sigma(c) + 0.004 * double{expected[c]});
        }
    }
}

TEST(PathTracer, EmissiveVoxelsShineThroughAbsorbingFog) {
    VoxelCloud cloud;
    cloud.depth = 4;
    cloud.voxels.push_back(make_voxel({8, 0, 8}, pack_rgb(Rgb(0.5f)), pack_rgb(Rgb(10.0f))));
    World world;
    world.tree = VoxelTree::build(cloud);
    world.media = Media({{.name = "smoke",
                          .absorption_per_m = Rgb(0.1f, 0.2f, 0.4f),
                          .shape = HomogeneousShape{}}});
    const Ray ray{{8.5, 6.0, 8.5}, {0, -1, 0}};
    const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
    const auto got = test::mean_radiance(tracer, 40000, 3, [&](RandomStream&) { return ray; });
    for (int c = 0; c < 3; ++c) {
        const double exact = 10.0 * std::exp(-5.0 * double{Rgb(0.1f, 0.2f, 0.4f)[c]});
        expect_mean(got, c, exact);
    }
    world.lighting.emission = false;
    EXPECT_EQ(test::mean_radiance(tracer, 100, 3, [&](RandomStream&) { return ray; }).mean(0), 0.0);
}

// Media that do not scatter: no flights, so that only null collisions vary.
TEST(PathTracer, WhatDoesNotScatterIsPassedByTransmittance) {
    const Ray ray{{-10.0, 0.3, 0.1}, {1, 0, 0}};
    for (const Rgb& absorb : {Rgb(0.3f), Rgb(0.1f, 0.2f, 0.4f)}) {
        for (const float emission : {0.0f, 2.0f}) {
            SCOPED_TRACE(testing::Message() << absorb.b << " 1/m, emission " << emission);
            World world;
            world.media = Media({{.name = "smoke",
                                  .absorption_per_m = absorb,
                                  .emission = Rgb(emission),
                                  .shape = test::noise_cloud(8)},
                                 {.name = "fog",
                                  .absorption_per_m = absorb * 0.1f,
                                  .emission = Rgb(emission),
                                  .shape = FogShape{-2.0, 3.0, Box{Vec3(-6.0), Vec3(6.0)}}}},
                                {.max_depth = 4, .threshold = 0.2});
            world.lighting.sky = Sky(Rgb(1.0f));
            const TrackerChoice choice = choose_tracker(facts_of(world.media));
            EXPECT_EQ(choice.tracker, TrackerKind::kTransmittance);
            const auto got = test::mean_radiance(PathTracer(world.scene(), choice), 20000, 5,
                                                 [&](RandomStream&) { return ray; });
            const auto flown = test::mean_radiance(
                PathTracer(world.scene(), test::forced(world.media, TrackerKind::kSpectralMis)),
                20000, 6, [&](RandomStream&) { return ray; });
            const Spectrum<3> depth = world.media.optical_depth(ray, {});
            for (int c = 0; c < 3; ++c) {
                const double through = std::exp(-depth[c]);
                const double exact = through + double{emission} * (1.0 - through);
                expect_mean(got, c, exact, 4.5);
                expect_mean(flown, c, exact, 4.5);
                EXPECT_LT(got.at(c).variance(), 0.7 * flown.at(c).variance());
            }
        }
    }
}

// Single scattering of a thin haze: the integral along the ray, to first order.
TEST(PathTracer, AThinHazeScattersTheSunOnce) {
    World world;
    const double per_m = 1e-4;
    world.media = Media({{.name = "haze",
                          .scattering_per_m = Rgb(static_cast<float>(per_m)),
                          .g = 0.6,
                          .shape = HomogeneousShape{Box{{0, 0, 0}, {10, 10, 10}}}}});
    world.lighting.sun = Sun{.direction = {0.6, 0.0, 0.8}, .irradiance = Rgb(5.0f)};
    const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
    const Ray ray{{-5, 5, 5}, {1, 0, 0}};
    const auto got = test::mean_radiance(tracer, 400000, 4, [&](RandomStream&) { return ray; });
    // Light travels along −direction, on towards the eye along −ray.
    const double phase = henyey_greenstein(
        0.6, glm::dot(ray.direction, glm::normalize(world.lighting.sun->direction)));
    const double exact = 5.0 * phase * per_m * 10.0;
    EXPECT_NEAR(got.mean(0), exact, 4.0 * got.sigma(0) + 0.002 * exact);
    EXPECT_LT(got.sigma(0), 0.1 * exact);
}

// A wall shadows the haze behind it.
TEST(PathTracer, VoxelsShadowMedia) {
    VoxelCloud cloud;
    cloud.depth = 6;
    test::add_box(cloud, {0, 30, 0}, {64, 31, 64});
    World world;
    world.tree = VoxelTree::build(cloud);
    world.media = Media({{.name = "haze",
                          .scattering_per_m = Rgb(0.01f),
                          .shape = HomogeneousShape{Box{{0, 0, 0}, {64, 30, 64}}}}});
    world.lighting.sun = Sun{.direction = {0, 1, 0}, .irradiance = Rgb(1.0f)};
    const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
    const Ray below{{32, 15, -5}, {0, 0, 1}};
    const Ray above{{32, 45, -5}, {0, 0, 1}};
    EXPECT_EQ(test::mean_radiance(tracer, 5000, 5, [&](RandomStream&) { return below; }).mean(0),
              0.0);
    World open = world;
    open.tree = VoxelTree();
    const PathTracer unshadowed(open.scene(), choose_tracker(facts_of(open.media)));
    EXPECT_GT(
        test::mean_radiance(unshadowed, 5000, 5, [&](RandomStream&) { return below; }).mean(0),
        0.0);
    EXPECT_EQ(test::mean_radiance(tracer, 100, 5, [&](RandomStream&) { return above; }).mean(0),
              0.0);
}

// All trackers agree on a coloured, absorbing cloud over ground in sun and sky.
TEST(PathTracer, AllTrackersAgree) {
    World world = ground(Media({{.name = "cloud",
                                 .absorption_per_m = Rgb(0.1f, 0.05f, 0.02f),
                                 .scattering_per_m = Rgb(0.4f, 0.6f, 0.9f),
                                 .g = 0.5,
                                 .shape =
                                     [] {
                                         GridShape shape = test::noise_cloud(7);
                                         shape.index_to_world.offset.y += 10.0;
                                         return shape;
                                     }()}},
                               {.max_depth = 5, .threshold = 0.1}));
    world.lighting.sun = Sun{.direction = {1, 2, 0.5}, .irradiance = Rgb(3.0f)};
    world.lighting.sky = Sky(SkyGradient{Rgb(0.2f, 0.4f, 1.0f), Rgb(1.0f), Rgb(0.1f)});
    const auto ray = [](RandomStream& random) {
        return Ray{{random.uniform() * 4.0 - 2.0, 25.0, random.uniform() * 4.0 - 2.0}, {0, -1, 0}};
    };
    const PathTracer reference(world.scene(), test::forced(world.media, TrackerKind::kDelta));
    const auto expected = test::mean_radiance(reference, 100000, 11, ray);
    for (const TrackerKind kind : test::heterogeneous_trackers()) {
        SCOPED_TRACE(name_of(kind));
        const PathTracer tracer(world.scene(), test::forced(world.media, kind));
        const auto got = test::mean_radiance(tracer, 40000, 12, ray);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(got.mean(c), expected.mean(c),
                        4.5 * std::hypot(got.sigma(c), expected.sigma(c)));
        }
    }
    for (const TransmittanceKind kind :
         {TransmittanceKind::kDelta, TransmittanceKind::kRatio, TransmittanceKind::kResidualRatio,
          TransmittanceKind::kClosedForm}) {
        SCOPED_TRACE(name_of(kind));
        TrackerChoice choice = choose_tracker(facts_of(world.media));
        EXPECT_EQ(choice.transmittance, TransmittanceKind::kRatioRoulette);
        choice.transmittance = kind;
        const auto got = test::mean_radiance(PathTracer(world.scene(), choice), 40000, 13, ray);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(got.mean(c), expected.mean(c),
                        4.5 * std::hypot(got.sigma(c), expected.sigma(c)));
        }
    }
}

TEST(PathTracer, APathIsAFunctionOfItsRandomNumbers) {
    World world = ground(
        Media({{.name = "cloud", .scattering_per_m = Rgb(1, 2, 3), .shape = test::noise_cloud()}}));
    world.lighting.sky = Sky(Rgb(1.0f));
    const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
    PathCount a;
    PathCount b;
    for (uint64_t i = 0; i < 100; ++i) {
        PathRandom first(i);
        PathRandom second(i);
        const Ray ray{{0.0, 5.0, 0.0}, {0.0, -1.0, 0.0}};
        EXPECT_EQ(tracer.trace(ray, {}, first, a).radiance,
                  tracer.trace(ray, {}, second, b).radiance);
    }
    EXPECT_EQ(a, b);
}

TEST(Choice, LeavesOutWhatIsNotNeeded) {
    const auto choose = [](const MediumSpec& spec) {
        return choose_tracker(facts_of(Media({spec})));
    };
    const GridShape cloud = test::noise_cloud();
    EXPECT_EQ(choose_tracker(facts_of(Media())).tracker, TrackerKind::kNone);
    EXPECT_EQ(choose({.scattering_per_m = Rgb(1, 2, 3), .shape = HomogeneousShape{}}).tracker,
              TrackerKind::kClosedForm);
    const TrackerChoice gray = choose({.scattering_per_m = Rgb(1), .shape = cloud});
    EXPECT_EQ(gray.tracker, TrackerKind::kDelta);
    EXPECT_TRUE(gray.gray);
    EXPECT_FALSE(gray.absorbs);
    EXPECT_EQ(gray.left_out.size(), 3u);
    // Only the albedo is coloured.
    EXPECT_TRUE(choose({.absorption_per_m = Rgb(0.5f, 0.25f, 0),
                        .scattering_per_m = Rgb(0.5f, 0.75f, 1),
                        .shape = cloud})
                    .gray);
    EXPECT_EQ(choose({.scattering_per_m = Rgb(1, 2, 4), .shape = cloud}).tracker,
              TrackerKind::kHistoryAverage);
    EXPECT_EQ(choose({.scattering_per_m = Rgb(1, 10, 100), .shape = cloud}).tracker,
              TrackerKind::kSpectralMis);
    EXPECT_EQ(choose({.scattering_per_m = Rgb(0, 1, 1), .shape = cloud}).tracker,
              TrackerKind::kSpectralMis);
    EXPECT_EQ(choose({.absorption_per_m = Rgb(1, 2, 4), .shape = cloud}).tracker,
              TrackerKind::kTransmittance);
    EXPECT_EQ(choose({.absorption_per_m = Rgb(1), .shape = HomogeneousShape{}}).tracker,
              TrackerKind::kTransmittance);
    for (int i = 0; i < kTrackerKinds; ++i) {
        const auto kind = static_cast<TrackerKind>(i);
        EXPECT_EQ(tracker_named(name_of(kind)), kind);
    }
    EXPECT_FALSE(tracker_named("sphere_tracing"));
    ChoiceParams closed;
    closed.forced = TrackerKind::kClosedForm;
    const MediaFacts facts = facts_of(Media({{.scattering_per_m = Rgb(1), .shape = cloud}}));
    EXPECT_THROW(choose_tracker(facts, closed), std::invalid_argument);
    ChoiceParams transmittance;
    transmittance.forced = TrackerKind::kTransmittance;
    EXPECT_THROW(choose_tracker(facts, transmittance), std::invalid_argument);
}

TEST(SkySampler, DensitiesAreThoseOfTheSamples) {
    auto image = std::make_shared<Image>(32, 16);
    RandomStream random(20);
    for (Rgb& pixel : image->pixels()) {
        pixel =
            Rgb(random.uniform() < 0.5 ? 0.0f : static_cast<float>(std::pow(random.uniform(), 9)));
    }
    const Sky sky(SkyPicture{image, 1.0, 33.0});
    const SkySampler sampler(sky);
    // ∫ L dω by importance, and by uniform directions; ∫ pdf dω = 1.
    Moments by_importance;
    Moments uniform;
    Moments density;
    for (int i = 0; i < 200000; ++i) {
        const double u = random.uniform();
        const SkySampler::Sample s = sampler.sample(u, random.uniform());
        ASSERT_NEAR(glm::length(s.direction), 1.0, 1e-9);
        by_importance.add(double{sky.radiance(s.direction).r} / s.pdf);
        const double y = 2.0 * random.uniform() - 1.0;
        const Vec3 d = around(Vec3(0, 1, 0), y, random.uniform());
        uniform.add(double{sky.radiance(d).r} * 4.0 * kPi);
        density.add(sampler.pdf(d) * 4.0 * kPi);
        if (sky.radiance(d).r > 0.0f) {
            ASSERT_GT(sampler.pdf(d), 0.0);
        }
    }
    const auto sigma = [](const Moments& m) { return std::sqrt(m.variance() / 200000.0); };
    EXPECT_NEAR(by_importance.mean(), uniform.mean(),
                4.0 * std::hypot(sigma(by_importance), sigma(uniform)));
    EXPECT_NEAR(density.mean(), 1.0, 4.0 * sigma(density));
    EXPECT_LT(sigma(by_importance), 0.5 * sigma(uniform));
    EXPECT_TRUE(SkySampler(Sky(Rgb(1.0f))).empty());
}

}  // namespace
}  // namespace probebake
