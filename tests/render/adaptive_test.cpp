#include "render/adaptive.h"

#include <gtest/gtest.h>

#include <limits>

#include "render/render.h"
#include "render/render_fixture.h"

namespace probebake {
namespace {

TEST(Adaptive, VariationIsTheSumOfSquaredDifferences) {
    // 3 × 3, by hand: luminances 1..9, mean 5, Σ = 2·(16 + 9 + 4 + 1) = 60.
    std::vector<OneRayPixel> pixels;
    for (int i = 1; i <= 9; ++i) pixels.push_back({static_cast<float>(i), true, true});
    EXPECT_EQ(luminance_variation(pixels, 3, 3, 1, 1, MissesInKernel::kLeftOut), 60.0);
    // In the corner: 1 2 4 5, mean 3, Σ = 4 + 1 + 1 + 4.
    EXPECT_EQ(luminance_variation(pixels, 3, 3, 0, 0, MissesInKernel::kLeftOut), 10.0);
    // A miss counts as black or not at all: 2 4 5 about 11/3, or 0 2 4 5 about 11/4.
    pixels[0] = {1.0f, true, false};
    EXPECT_NEAR(luminance_variation(pixels, 3, 3, 0, 0, MissesInKernel::kLeftOut), 14.0 / 3, 1e-12);
    EXPECT_NEAR(luminance_variation(pixels, 3, 3, 0, 0, MissesInKernel::kBlack), 14.75, 1e-12);
    // A pixel that another face owns is no part of the image either way.
    pixels[0].rendered = false;
    EXPECT_NEAR(luminance_variation(pixels, 3, 3, 0, 0, MissesInKernel::kBlack), 14.0 / 3, 1e-12);
}

TEST(Adaptive, ClassesAreTheThesiss) {
    EXPECT_EQ(adaptive_grid(0.75, 1.0), 4);
    EXPECT_EQ(adaptive_grid(0.7499, 1.0), 2);
    EXPECT_EQ(adaptive_grid(0.25, 1.0), 2);
    EXPECT_EQ(adaptive_grid(0.2499, 1.0), 0);
    EXPECT_EQ(adaptive_grid(5.0, std::numeric_limits<double>::infinity()), 0);
}

TEST(Adaptive, TheSolvedNormaliserSpendsTheBudgetAndNoMore) {
    RandomStream random(4);
    std::vector<double> variations;
    variations.reserve(1000);
    for (int i = 0; i < 1000; ++i) variations.push_back(random.uniform() * random.uniform());
    const auto cost = [&](double normaliser) {
        uint64_t rays = variations.size();
        for (const double v : variations) {
            const int grid = adaptive_grid(v, normaliser);
            rays += static_cast<uint64_t>(grid * grid);
        }
        return rays;
    };
    for (const uint64_t budget : {1000u, 1003u, 1004u, 1500u, 4000u, 9000u, 16999u, 17000u}) {
        const double normaliser = solve_normaliser(variations, budget);
        EXPECT_LE(cost(normaliser), budget);
        EXPECT_GT(cost(normaliser) + 17, std::min<uint64_t>(budget, 17000)) << budget;
    }
    EXPECT_EQ(solve_normaliser(variations, 0), std::numeric_limits<double>::infinity());
    EXPECT_EQ(adaptive_grid(1.0, solve_normaliser({}, 10)), 0);
}

TEST(Adaptive, RendersEachPixelInItsClass) {
    const VoxelTree tree = test::small_world();
    const RenderScene scene{.tree = tree, .color = tree.colors().albedo};
    const View view = perspective_view(
        {.origin = {32, 61, 32}, .forward = {0.1, -1, 0.05}, .width_px = 40, .height_px = 40});
    RenderSettings settings{.kind = RendererKind::kAdaptive, .normaliser = 0.8};
    const ViewRender render = render_view(scene, view, settings, CancelToken());

    std::vector<OneRayPixel> first;
    CostStats cost;
    for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 40; ++x) {
            CostStats one;
            const PixelSums sums = lod_pixel(scene, view, x, y, settings, one);
            first.push_back({luminance(sums.mean()), true, one.missed_rays == 0});
            cost += one;
        }
    }
    int classes[5] = {};
    uint64_t rays = 0;
    for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 40; ++x) {
            const int grid = adaptive_grid(
                luminance_variation(first, 40, 40, x, y, settings.misses_in_kernel), 0.8);
            ++classes[grid];
            rays += grid == 0 ? 1 : static_cast<uint64_t>(1 + grid * grid);
            CostStats ignored;
            const Rgb expected = grid == 0 ? lod_pixel(scene, view, x, y, settings, ignored).mean()
                                           : uniform_pixel(scene, view, x, y, grid, ignored).mean();
            ASSERT_EQ(render.color.at(x, y), expected);
        }
    }
    EXPECT_EQ(render.stats.all_rays(), rays);
    EXPECT_EQ(render.stats.discarded_rays, static_cast<uint64_t>(classes[2] + classes[4]));
    EXPECT_GT(classes[0], 50);
    EXPECT_GT(classes[2], 50);
    EXPECT_GT(classes[4], 50);
}

}  // namespace
}  // namespace probebake
