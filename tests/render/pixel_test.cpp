#include "render/pixel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

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
    const VoxelTree tree;
    const RenderScene scene{
        .tree = tree, .color = tree.colors().albedo, .range = {.t_max = 1.0}, .near_limit = 0.7};
    PixelSums sums;
    double mean = 0.0;
    for (const double v : values) mean += v / 6.0;
    double variance = 0.0;
    for (const double v : values) variance += (v - mean) * (v - mean) / 5.0;
    for (const double v : values) {
        sums.add(scene, Rgb(static_cast<float>(v), 0.5f, 0.0f), 2.0 * v, 1.0 / 6.0);
    }
    EXPECT_NEAR(sums.standard_error().r, std::sqrt(variance / 6.0), 1e-6);
    EXPECT_NEAR(sums.standard_error().g, 0.0, 1e-6);
    EXPECT_NEAR(sums.color.r, mean, 1e-6);
    EXPECT_EQ(sums.samples, 6);
    // Distances 0.2, 1, 0.8, 0.7, 1, 0.4: capped at 1.
    EXPECT_NEAR(sums.distance, 4.1 / 6.0, 1e-12);
    // And at 0.7: every ray, not their mean.
    EXPECT_NEAR(sums.near_distance, 3.4 / 6.0, 1e-12);
    EXPECT_NEAR(sums.squared_near_distance, (4 * 0.49 + 0.04 + 0.16) / 6.0, 1e-12);
    EXPECT_NEAR(sums.scaled(2.0).squared_near_distance, 2.16 / 3.0, 1e-12);
    PixelSums single;
    single.add(scene, Rgb(1.0f), 1.0, 1.0);
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

/// Largest distance between what a run of shifts says of [−½, ½) and its length.
double discrepancy(std::vector<double> shifts) {
    std::sort(shifts.begin(), shifts.end());
    const auto n = static_cast<double>(shifts.size());
    double largest = 0.0;
    for (size_t i = 0; i < shifts.size(); ++i) {
        const double below = shifts[i] + 0.5;
        largest = std::max({largest, std::abs(below - static_cast<double>(i) / n),
                            std::abs(below - static_cast<double>(i + 1) / n)});
    }
    return largest;
}

TEST(GridShift, IsSpreadEvenlyAlongRowsAndColumns) {
    // Runs of 16 random shifts: 0.21 in the mean.
    double sum = 0.0;
    int count = 0;
    for (int at = 0; at < 512; at += 37) {
        for (int start = 0; start < 496; start += 31) {
            std::array<std::vector<double>, 4> runs;
            for (int i = start; i < start + 16; ++i) {
                runs[0].push_back(grid_shift(i, at).x);
                runs[1].push_back(grid_shift(i, at).y);
                runs[2].push_back(grid_shift(at, i).x);
                runs[3].push_back(grid_shift(at, i).y);
            }
            for (const auto& run : runs) {
                for (const double shift : run) ASSERT_TRUE(shift >= -0.5 && shift < 0.5);
                ASSERT_LT(discrepancy(run), 0.21) << "row " << at << ", from " << start;
                sum += discrepancy(run);
                ++count;
            }
        }
    }
    EXPECT_LT(sum / count, 0.14);
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
