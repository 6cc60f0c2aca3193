#include "render/pixel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/render_fixture.h"

namespace probebake {
namespace {

TEST(PixelRay, ConeStopsAtTheNodeNearestInSizeToThePixel) {
    // A pixel that covers 4 voxels at the distance of a wall stops at nodes of edge 4, up to
    // distances where it covers √2 · 4 (then 8 is nearer).
    const View view = cube_face_view(CubeFace::kPosX, 65, Vec3(0.0));
    const PixelRay centre = pixel_ray(view, 32, 32);
    const double spacing = view.pixel_spacing();
    EXPECT_NEAR(centre.cone, std::sqrt(2.0) * spacing, 1e-15);
    EXPECT_LE(4.0, centre.cone * (4.0 / spacing));
    EXPECT_GT(8.0, centre.cone * (4.0 / spacing));
    // Off axis the plane of the pixel is nearer than the ray is long.
    const PixelRay corner = pixel_ray(view, 64, 64);
    EXPECT_NEAR(corner.cone, std::sqrt(2.0) * spacing / std::sqrt(3.0), 1e-15);
    EXPECT_NEAR(pixel_ray(view, 32, 32, 0.5).cone, centre.cone / 2, 1e-15);
}

TEST(PixelSums, StandardErrorIsThatOfTheMean) {
    const std::vector<double> values = {0.1, 0.7, 0.4, 0.35, 0.9, 0.2};
    PixelSums sums;
    double mean = 0.0;
    for (const double v : values) mean += v / 6.0;
    double variance = 0.0;
    for (const double v : values) variance += (v - mean) * (v - mean) / 5.0;
    for (const double v : values) {
        sums.add(Rgb(static_cast<float>(v), 0.5f, 0.0f), 2.0 * v, 1.0, 1.0 / 6.0);
    }
    EXPECT_NEAR(sums.standard_error().r, std::sqrt(variance / 6.0), 1e-6);
    EXPECT_NEAR(sums.standard_error().g, 0.0, 1e-6);
    EXPECT_NEAR(sums.color.r, mean, 1e-6);
    EXPECT_EQ(sums.samples, 6);
    // Distances 0.2, 1, 0.8, 0.7, 1, 0.4: capped at 1.
    EXPECT_NEAR(sums.distance, 4.1 / 6.0, 1e-12);
    PixelSums single;
    single.add(Rgb(1.0f), 1.0, 10.0, 1.0);
    EXPECT_EQ(single.standard_error(), Rgb(0.0f));
}

TEST(StratifiedPixel, IsAnUnbiasedEstimateOfTheFootprintsMean) {
    const VoxelTree tree = test::small_world();
    const RenderScene scene{.tree = tree, .color = tree.colors().albedo, .background = Rgb(0.2f)};
    const View view = cube_face_view(CubeFace::kPosY, 8, test::kSmallWorldProbe);
    // Means of 400 estimates against a 256×256 grid: sees a bias of about 4 standard errors, here
    // about 0.012 in albedo.
    const int kRuns = 400;
    CostStats stats;
    for (const auto& [x, y] : {std::pair{3, 2}, std::pair{5, 6}, std::pair{0, 7}}) {
        const Vec3 truth = uniform_pixel(scene, view, x, y, 256, stats).color;
        const StartList from = start_list(tree, pixel_beam(view, {x, y, x, y}, 1.0));
        double sum = 0.0;
        double sum2 = 0.0;
        for (int run = 0; run < kRuns; ++run) {
            RandomStream random(random_key({5, static_cast<uint64_t>(run)}));
            const double value = stratified_pixel(scene, view, x, y, 4, from, random, stats).g;
            sum += value;
            sum2 += value * value;
        }
        const double mean = sum / kRuns;
        const double error = std::sqrt((sum2 / kRuns - mean * mean) / kRuns);
        EXPECT_LT(error, 0.003);
        EXPECT_NEAR(mean, truth.g, 4.0 * error + 2e-4) << x << ", " << y;
        EXPECT_GT(std::abs(mean + 0.015 - truth.g), 4.0 * error + 2e-4);  // a bias it must see
    }
}

TEST(UniformPixel, CountsItsRaysAndShowsTheBackgroundWhereNothingIsHit) {
    const VoxelTree empty = VoxelTree::build({});
    const RenderScene scene{
        .tree = empty, .color = empty.colors().albedo, .background = Rgb(0.25f)};
    const View view = cube_face_view(CubeFace::kNegZ, 4, Vec3(1.0));
    CostStats stats;
    EXPECT_EQ(uniform_pixel(scene, view, 1, 1, 4, stats).mean(), Rgb(0.25f));
    EXPECT_EQ(stats.rays, 16u);
    EXPECT_EQ(stats.missed_rays, 16u);
    EXPECT_EQ(stats.steps, 0u);
}

}  // namespace
}  // namespace probebake
