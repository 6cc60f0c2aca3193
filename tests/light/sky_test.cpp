#include "light/sky.h"

#include <cmath>
#include <numbers>

#include "light/light_fixture.h"
#include "light/sky_light.h"
#include "math/estimate.h"
#include "support/ray_families.h"

namespace probebake {
namespace {

constexpr double kPi = std::numbers::pi;

std::shared_ptr<Image> picture(int width, const Rgb& color) {
    auto image = std::make_shared<Image>(width, width / 2);
    for (Rgb& pixel : image->pixels()) pixel = color;
    return image;
}

TEST(Sky, AGradientRisesFromTheHorizonToTheZenith) {
    const Sky sky(SkyGradient{Rgb(1.0f), Rgb(3.0f), Rgb(7.0f)});
    EXPECT_EQ(sky.radiance({0.0, 2.0, 0.0}), Rgb(1.0f));
    EXPECT_EQ(sky.radiance({5.0, 0.0, 1.0}), Rgb(3.0f));
    EXPECT_EQ(sky.radiance({3.0, -1e-9, 0.0}), Rgb(7.0f));
    EXPECT_NEAR(sky.radiance({0.0, 1.0, std::sqrt(3.0)}).r, 2.0, 1e-6);  // 30 degrees up
}

TEST(Sky, APictureIsTurnedAsDocumented) {
    // Left edge to right edge: -Z, +X, +Z, -X, -Z; the top is +Y.
    const auto expect_at = [](const Vec3& direction, double x, double y) {
        const Vec2 got = equirect_position(direction);
        EXPECT_NEAR(got.x, x, 1e-12);
        EXPECT_NEAR(got.y, y, 1e-12);
    };
    expect_at({0, 0, 1}, 0.5, 0.5);
    expect_at({-1, 0, 0}, 0.75, 0.5);
    expect_at({1, 0, 0}, 0.25, 0.5);
    expect_at({0, 1, 1}, 0.5, 0.25);
    expect_at({0, -1, 0}, 0.5, 1.0);
    RandomStream random(1);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 d = test::random_direction(random);
        EXPECT_LT(glm::length(equirect_direction(equirect_position(d)) - d), 1e-12);
    }
    auto image = picture(8, Rgb(0.0f));
    image->at(4, 1) = Rgb(1.0f);  // just right of the centre, above the horizon
    const Vec3 there = glm::normalize(Vec3(-std::sin(kPi / 8), 0.4, std::cos(kPi / 8)));
    EXPECT_EQ(Sky(SkyPicture{image, 2.0}).radiance(there), Rgb(2.0f));
    // Turned by 90 degrees from +Z towards +X.
    const Vec3 turned(there.z, there.y, -there.x);
    EXPECT_EQ(Sky(SkyPicture{image, 2.0, 90.0}).radiance(turned), Rgb(2.0f));
    EXPECT_EQ(Sky(SkyPicture{image, 2.0, 90.0}).radiance(there), Rgb(0.0f));
}

TEST(SkyLight, SquareAndHemisphereMapOntoEachOther) {
    RandomStream random(2);
    for (int i = 0; i < 10000; ++i) {
        const CubeFace face = kCubeFaces[random.below(6)];
        const Vec2 square(random.uniform(), random.uniform());
        const Vec3 direction = cosine_direction(face, square);
        EXPECT_NEAR(glm::length(direction), 1.0, 1e-12);
        const double sign = index_of(face) % 2 == 0 ? 1.0 : -1.0;
        EXPECT_GT(sign * direction[axis_of(face)], 0.0);
        EXPECT_LT(glm::length(cosine_square(face, direction) - square), 1e-9);
    }
}

TEST(SkyLight, AConstantSkyAndAConstantPictureGivePiTimesTheirRadianceOnEveryFace) {
    for (const int strata : {1, 7, 64}) {
        const SkyLight constant(Sky(Rgb(1.0f, 2.0f, 3.0f)), strata);
        const SkyLight image(Sky(SkyPicture{picture(64, Rgb(1.0f, 2.0f, 3.0f)), 1.0}), strata);
        for (const CubeFace face : kCubeFaces) {
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(constant.irradiance(face)[c], kPi * (c + 1), 1e-9);
                EXPECT_NEAR(image.irradiance(face)[c], kPi * (c + 1), 1e-9);
                double sum = 0.0;
                for (int s = 0; s < strata; ++s) sum += image.weight(face, s)[c];
                EXPECT_NEAR(sum, kPi * (c + 1), 1e-9);
            }
        }
    }
}

TEST(SkyLight, DirectionsFollowTheEnergy) {
    // A gradient: the mean direction of the strata's rays against the integral of L d cos.
    const Sky sky(SkyGradient{Rgb(1.0f), Rgb(9.0f), Rgb(2.0f)});
    const SkyLight light(sky, 64);
    for (const CubeFace face : {CubeFace::kPosY, CubeFace::kPosX, CubeFace::kNegZ}) {
        Vec3 expected(0.0);
        double energy = 0.0;
        const int side = 400;
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                const Vec3 d = cosine_direction(face, {(x + 0.5) / side, (y + 0.5) / side});
                const double l = sky.radiance(d).r;
                expected += d * l;
                energy += l;
            }
        }
        expected /= energy;
        Vec3 got(0.0);
        RandomStream random(4);
        for (int i = 0; i < 64000; ++i) got += light.direction(face, i % 64, random) / 64000.0;
        EXPECT_LT(glm::length(got - expected), 0.005) << index_of(face);
    }
}

/// A wall hides half of the sky from a patch of ground; the picture has a sun of one texel.
TEST(SkyLight, ASunInThePictureLightsFromItsSideWithoutNoise) {
    auto image = picture(512, Rgb(0.1f));
    // 30 degrees above the horizon towards +X, as bright as all the rest many times over.
    const Vec2 at = equirect_position({std::sqrt(3.0), 1.0, 0.01});
    image->at(static_cast<int>(at.x * 512), static_cast<int>(at.y * 256)) = Rgb(1e5f);
    const Lighting lighting{.sky = Sky(SkyPicture{image, 1.0})};
    VoxelCloud cloud = test::flat_ground(6);
    test::add_box(cloud, {32, 1, 0}, {33, 9, 64});
    const VoxelTree tree = VoxelTree::build(std::move(cloud));
    const LitScene lit = test::light(tree, lighting);
    const auto ground = [&](int x) {
        Moments moments;
        for (int z = 24; z < 40; ++z) {
            moments.add(test::radiance_of(tree, lit.colors, {x, 0, z}, CubeFace::kPosY).r);
        }
        return moments;
    };
    // The sun's side is lit; the shadow reaches 8 · √3 = 13.9 voxels beyond the wall.
    const Moments sunny = ground(40);
    const Moments shadow = ground(25);
    const Moments beyond = ground(10);
    EXPECT_GT(sunny.mean(), 20.0 * shadow.mean());
    EXPECT_NEAR(beyond.mean() / sunny.mean(), 1.0, 0.02);
    // Every gathering by itself: no fireflies, no holes.
    EXPECT_LT(std::sqrt(sunny.variance()), 0.02 * sunny.mean());
    EXPECT_LT(std::sqrt(beyond.variance()), 0.02 * beyond.mean());
    EXPECT_LT(shadow.mean() + 4.0 * std::sqrt(shadow.variance()), 0.1 * sunny.mean());
    // Walls: +X is turned to the sun, -X is not.
    const double bright = test::radiance_of(tree, lit.colors, {32, 5, 30}, CubeFace::kPosX).r;
    const double dark = test::radiance_of(tree, lit.colors, {32, 5, 30}, CubeFace::kNegX).r;
    EXPECT_GT(bright, 20.0 * dark);
}

TEST(SkyLight, ItsVarianceFallsWithTheRaysWhateverTheSkysContrast) {
    // Gatherings of a patch beside a wall, the edge of which cuts through the sun's cells.
    for (const float sun : {0.1f, 1e3f, 1e6f}) {
        auto image = picture(256, Rgb(0.1f));
        const Vec2 at = equirect_position({-1.0, 1.0, 0.01});
        image->at(static_cast<int>(at.x * 256), static_cast<int>(at.y * 128)) = Rgb(sun);
        VoxelCloud cloud;
        cloud.depth = 6;
        test::add_box(cloud, {30, 0, 0}, {40, 1, 64});
        test::add_box(cloud, {20, 1, 0}, {21, 17, 64});
        const VoxelTree tree = VoxelTree::build(std::move(cloud));
        double spread[2];
        for (const int i : {0, 1}) {
            const LitScene lit = test::light(tree, {.sky = Sky(SkyPicture{image, 1.0})},
                                             {.sky_rays = i == 0 ? 16 : 256});
            Moments moments;
            for (int z = 16; z < 48; ++z) {
                moments.add(test::radiance_of(tree, lit.colors, {36, 0, z}, CubeFace::kPosY).r);
            }
            spread[i] = std::sqrt(moments.variance()) / moments.mean();
        }
        EXPECT_LT(spread[0], 0.35) << sun;
        EXPECT_LT(spread[1], 0.09) << sun;
    }
}

}  // namespace
}  // namespace probebake
