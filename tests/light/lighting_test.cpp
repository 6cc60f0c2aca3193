#include "light/lighting.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <thread>

#include "light/light_fixture.h"

namespace probebake {
namespace {

constexpr double kPi = std::numbers::pi;
/// Shared-exponent values are within 2^-9 of the largest component.
constexpr double kPacked = 1.0 / 512.0;

TEST(Lighting, OpenGroundUnderAConstantSkyReflectsAlbedoTimesRadianceWithoutNoise) {
    const Rgb albedo(0.5f, 0.25f, 0.125f);
    const Rgb sky(3.0f, 5.0f, 7.0f);
    const VoxelTree tree = VoxelTree::build(test::flat_ground(5, albedo));
    for (const int level : {0, 2, 4}) {
        const LitScene lit = test::light(tree, {.sky = Sky(sky)}, {.gather_level = level});
        for (const IVec3 at : {IVec3(0, 0, 0), IVec3(7, 0, 19), IVec3(31, 0, 31)}) {
            for (const CubeFace face : {CubeFace::kPosY, CubeFace::kNegY}) {
                const Rgb got = test::radiance_of(tree, lit.colors, at, face);
                for (int c = 0; c < 3; ++c) {
                    EXPECT_NEAR(got[c], albedo[c] * sky[c], kPacked * 2.0);
                }
            }
        }
        EXPECT_EQ(lit.cost.faces, 32u * 32 * 2 + 4 * 32);
        EXPECT_EQ(lit.cost.sky_rays, 64 * lit.cost.gatherings);
    }
}

TEST(Lighting, ASunAtAnAngleLightsByItsCosine) {
    const VoxelTree tree = VoxelTree::build(test::flat_ground(4));
    const Vec3 direction = glm::normalize(Vec3(0.3, 0.8, -0.5));
    for (const double diameter : {0.0, 0.53, 20.0}) {
        const Sun sun{direction * 7.0, Rgb(100.0f, 200.0f, 400.0f), diameter};
        const LitScene lit = test::light(tree, {.sun = sun}, {.sun_rays = 16});
        const Rgb got = test::radiance_of(tree, lit.colors, {5, 0, 6}, CubeFace::kPosY);
        for (int c = 0; c < 3; ++c) {
            const double expected = 0.5 / kPi * double{sun.irradiance[c]} * direction.y;
            EXPECT_NEAR(got[c] / expected, 1.0, diameter > 1.0 ? 0.01 : 2.5 * kPacked) << diameter;
        }
        EXPECT_EQ(test::radiance_of(tree, lit.colors, {5, 0, 6}, CubeFace::kNegY), Rgb(0.0f));
    }
}

/// Ground with a wall along z at x = 64, 65 of height 20 above it.
VoxelTree walled_ground() {
    VoxelCloud cloud = test::flat_ground(7);
    test::add_box(cloud, {64, 1, 0}, {66, 21, 128});
    return VoxelTree::build(std::move(cloud));
}

TEST(Lighting, AWallCastsItsShadowWhereItShould) {
    const VoxelTree tree = walled_ground();
    const Sun sun{{1.0, 1.0, 0.0}, Rgb(static_cast<float>(kPi * 2.0)), 0.0};
    const LitScene lit = test::light(tree, {.sun = sun});
    for (int x = 0; x < 64; ++x) {
        for (const int z : {0, 50, 127}) {
            const Rgb got = test::radiance_of(tree, lit.colors, {x, 0, z}, CubeFace::kPosY);
            // At 45 degrees the shadow is as long as the wall is high: 20 voxels, to the voxel.
            EXPECT_NEAR(got.r, x >= 44 ? 0.0 : std::numbers::sqrt2 / 2.0, 2.0 * kPacked) << x;
        }
    }
}

TEST(Lighting, HalfAPenumbraLiesOnEitherSideOfTheSharpShadowsEdge) {
    const VoxelTree tree = walled_ground();
    const double diameter = 12.0;
    const Sun sun{{1.0, 1.0, 0.0}, Rgb(static_cast<float>(kPi * 2.0)), diameter};
    const LitScene lit = test::light(tree, {.sun = sun}, {.sun_rays = 64});
    const double full = std::numbers::sqrt2 / 2.0;
    const auto at_distance = [&](int x) {  // the mean over a stretch without ends of the wall
        double sum = 0.0;
        for (int z = 56; z < 72; ++z) {
            sum += test::radiance_of(tree, lit.colors, {63 - x, 0, z}, CubeFace::kPosY).r / 16.0;
        }
        return sum / full;
    };
    const double radius = diameter / 2.0 * kPi / 180.0;
    const double begin = 20.0 / std::tan(kPi / 4 + radius);  // 16.2 voxels from the wall
    const double end = 20.0 / std::tan(kPi / 4 - radius);    // 24.7
    double width = 0.0;
    for (int x = 0; x < 40; ++x) {
        const double share = at_distance(x);
        if (x + 1 < begin) {
            EXPECT_EQ(share, 0.0) << x;
        } else if (x > end) {
            EXPECT_NEAR(share, 1.0, 0.01) << x;
        }
        // What of the disc is above the wall, seen from the face's middle: the area beyond a chord.
        const double below = std::atan(20.0 / (x + 0.5)) - kPi / 4;
        const double h = std::clamp(below / radius, -1.0, 1.0);
        const double visible = (std::acos(h) - h * std::sqrt(1.0 - h * h)) / kPi;
        EXPECT_NEAR(share, visible, 0.04) << x;
        if (share > 0.01 && share < 0.99) width += 1.0;
    }
    EXPECT_NEAR(width, end - begin, 2.0);
}

/// Share of a constant sky that a rectangle hides from a horizontal patch: perpendicular to it at
/// distance c, of height a, reaching b to one side (view factor C-3 of Howell's catalogue).
double hidden_share(double a, double b, double c) {
    const double r = std::hypot(a, c);
    return (std::atan(b / c) - c / r * std::atan(b / r)) / (2.0 * kPi);
}

TEST(Lighting, AWallHidesItsShareOfTheSky) {
    VoxelCloud cloud;
    cloud.depth = 7;
    for (const int x : {8, 32, 52, 60}) test::add_box(cloud, {x, 0, 0}, {x + 4, 1, 128});
    test::add_box(cloud, {64, 1, 0}, {66, 21, 128});
    const VoxelTree tree = VoxelTree::build(std::move(cloud));
    for (const int level : {0, 2}) {
        const LitScene lit =
            test::light(tree, {.sky = Sky(Rgb(2.0f))}, {.sky_rays = 256, .gather_level = level});
        for (const int x : {63, 60, 52, 32, 8}) {
            // 64 gatherings of 48 rays, or 16 of 256: without the help of the strata their mean
            // would have a standard error of 0.008.
            double sum = 0.0;
            double expected = 0.0;
            for (int z = 32; z < 96; ++z) {
                sum += test::radiance_of(tree, lit.colors, {x, 0, z}, CubeFace::kPosY).r / 64.0;
                const int first = level == 0 ? x : x / 4 * 4;
                const int last = level == 0 ? x : first + 3;
                for (int of = first; of <= last; ++of) {
                    for (int i = 0; i < 16; ++i) {  // over the face
                        const double c = 64.0 - of - (i + 0.5) / 16.0;
                        const double hidden =
                            hidden_share(20.0, z + 0.5, c) + hidden_share(20.0, 127.5 - z, c);
                        expected += (1.0 - hidden) / (64.0 * 16.0 * (last - first + 1));
                    }
                }
            }
            EXPECT_NEAR(sum, expected, 0.004) << x << ", level " << level;
            EXPECT_GT(std::abs(sum - expected - 0.01), 0.004);  // a bias that it must see
        }
    }
}

TEST(Lighting, EmissionAddsToWhatAFaceReflectsAndCanBeLeftOut) {
    VoxelCloud cloud = test::flat_ground(4);
    cloud.voxels.back() = make_voxel({15, 0, 15}, pack_rgb(Rgb(0.5f)));
    VoxelTree tree = VoxelTree::build(std::move(cloud));
    ColorPyramid colors = tree.colors();
    std::vector<PackedRgb> emission(tree.voxel_count(), 0);
    emission[*tree.find_voxel({3, 0, 3})] = pack_rgb(Rgb(1000.0f, 0.0f, 500.0f));
    colors.emission = average_up(tree, emission, 4.0f);
    tree.set_colors(colors);
    const Lighting lighting{.sky = Sky(Rgb(2.0f))};
    const LitScene lit = test::light(tree, lighting);
    const Rgb got = test::radiance_of(tree, lit.colors, {3, 0, 3}, CubeFace::kPosY);
    EXPECT_NEAR(got.r, 4001.0, 4001.0 * kPacked);
    EXPECT_NEAR(got.g, 1.0, 4001.0 * kPacked);
    EXPECT_NEAR(got.b, 2001.0, 4001.0 * kPacked);
    const LitScene dark = test::light(tree, {.sky = lighting.sky, .emission = false});
    EXPECT_NEAR(test::radiance_of(tree, dark.colors, {3, 0, 3}, CubeFace::kPosY).r, 1.0, kPacked);
    // Radiance times area is the same at every level: the root shows the mean over its faces.
    const FaceLevel& nodes = lit.colors.nodes;
    const Rgb root =
        unpack_rgb(nodes.values[nodes.index_of(0, index_of(CubeFace::kPosY))]) * lit.colors.scale;
    EXPECT_NEAR(root.r, 1.0 + 4000.0 / 256.0, 17.0 * kPacked);
}

TEST(Lighting, TheSameForAnyNumberOfThreads) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    const VoxelTree tree = VoxelTree::build(test::random_cloud(5, 0.05, 3));
    const Lighting lighting{.sun = Sun{{0.3, 1.0, 0.2}, Rgb(500.0f), 0.53},
                            .sky = Sky(SkyGradient{Rgb(20.0f), Rgb(50.0f), Rgb(5.0f)})};
    LitScene expected;
    for (const int threads : {1, 2, 7}) {
        tbb::task_arena arena(threads);
        LitScene got;
        arena.execute([&] { got = test::light(tree, lighting, {.gather_level = 1}); });
        if (threads == 1) {
            expected = std::move(got);
            continue;
        }
        EXPECT_TRUE(got.colors == expected.colors) << threads;
        EXPECT_EQ(got.cost.steps, expected.cost.steps);
    }
    const LitScene other = test::light(tree, lighting, {.gather_level = 1, .seed = 2});
    EXPECT_FALSE(other.colors == expected.colors);
}

TEST(Lighting, StopsWithinASecondWhenCancelled) {
    const VoxelTree tree = VoxelTree::build(test::random_cloud(7, 0.05, 4));
    const Lighting lighting{.sun = Sun{{0.3, 1.0, 0.2}, Rgb(500.0f), 0.53}, .sky = Sky(Rgb(1.0f))};
    CancelToken cancel;
    std::chrono::steady_clock::time_point asked;
    std::thread canceller([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        asked = std::chrono::steady_clock::now();
        cancel.cancel();
    });
    EXPECT_THROW(light_scene(tree, lighting, {.sun_rays = 64, .sky_rays = 4096}, cancel),
                 Cancelled);
    const auto stopped = std::chrono::steady_clock::now();
    canceller.join();
    EXPECT_LT(std::chrono::duration<double>(stopped - asked).count(), 1.0);
}

TEST(Lighting, RefusesWhatIsNoLight) {
    const VoxelTree tree = VoxelTree::build(test::flat_ground(3));
    const double nan = std::nan("");
    const auto with = [&](const Sun& sun) { return test::light(tree, {.sun = sun}); };
    EXPECT_THROW(with({{0, 0, 0}, Rgb(1.0f)}), std::invalid_argument);
    EXPECT_THROW(with({{0, nan, 0}, Rgb(1.0f)}), std::invalid_argument);
    EXPECT_THROW(with({{0, 1, 0}, Rgb(-1.0f)}), std::invalid_argument);
    EXPECT_THROW(with({{0, 1, 0}, Rgb(1.0f), nan}), std::invalid_argument);
    EXPECT_THROW(test::light(tree, {.sky = Sky(Rgb(1.0f, -1.0f, 0.0f))}), std::invalid_argument);
    EXPECT_THROW(test::light(tree, {}, {.sky_rays = 0}), std::invalid_argument);
    EXPECT_THROW(test::light(tree, {}, {.gather_level = 5}), std::invalid_argument);
}

TEST(Lighting, AnEmptySceneIsLitToo) {
    const VoxelTree empty = VoxelTree::build({});
    EXPECT_EQ(test::light(empty, {.sky = Sky(Rgb(1.0f))}).cost.faces, 0u);
}

}  // namespace
}  // namespace probebake
