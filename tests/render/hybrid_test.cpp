#include "render/hybrid.h"

#include <gtest/gtest.h>

#include <numeric>

#include <limits>

#include "render/error_aware.h"
#include "render/hybrid_view.h"
#include "render/render.h"
#include "render/render_fixture.h"

namespace probebake {
namespace {

constexpr int kSize = 12;
constexpr double kNever = std::numeric_limits<double>::infinity();

class HybridTest : public testing::Test {
  protected:
    static RenderSettings settings(double price, int leaf_grid = 16) {
        return {.kind = RendererKind::kHybrid, .leaf_grid = leaf_grid, .price = price};
    }
    CubemapRender render(const RenderSettings& settings,
                         std::optional<uint64_t> ray_limit = {}) const {
        return render_cubemap(scene_, test::kSmallWorldProbe, kSize, settings, cancel_, ray_limit);
    }
    /// Mean squared error against leaf rays on 24 × 24 regular places.
    double error_of(const Cubemap& cube) const {
        double sum = 0.0;
        int count = 0;
        for (const CubeFace face : kCubeFaces) {
            const View view = cube_face_view(face, kSize, test::kSmallWorldProbe);
            for (int y = 0; y < kSize; ++y) {
                for (int x = 0; x < kSize; ++x) {
                    CostStats stats;
                    const Vec3 d(uniform_pixel(scene_, view, x, y, 24, stats).mean() -
                                 cube.at({face, x, y}));
                    sum += glm::dot(d, d) / 3.0;
                    ++count;
                }
            }
        }
        return sum / count;
    }

    VoxelTree tree_ = test::small_world();
    RenderScene scene_{.tree = tree_, .color = tree_.colors().albedo, .background = Rgb(0.1f)};
    CancelToken cancel_;
};

TEST_F(HybridTest, ARaySeesALeafAndShowsItsAncestor) {
    const View view = cube_face_view(CubeFace::kNegY, kSize, test::kSmallWorldProbe);
    bool coarse = false;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            const PixelRay cast = pixel_ray(view, x, y);
            const Hit leaf = trace(tree_, cast.ray);
            HybridPixel pixel;
            cast_stage({scene_, view, x, y}, pixel);
            ASSERT_EQ(pixel.cost.rays, 1u);
            ASSERT_EQ(pixel.cost.steps, leaf.steps);
            ASSERT_EQ(pixel.cost.missed_rays, leaf ? 0u : 1u);
            if (!leaf) {
                ASSERT_EQ(pixel.color(), scene_.background);
                continue;
            }
            // The coarsest ancestor that the footprint covers.
            int level = 0;
            while (level < tree_.depth() && std::ldexp(1.0, level + 1) <= cast.cone * leaf.t) {
                ++level;
            }
            coarse = coarse || level > 0;
            ASSERT_EQ(pixel.cost.level_histogram[static_cast<size_t>(level)], 1u);
            ASSERT_EQ(pixel.color(), scene_.color[color_index(tree_, leaf, level)]);
            ASSERT_EQ(pixel.sums.distance, leaf.t);
            // A level finer, where the scene asks for it.
            RenderScene finer = scene_;
            finer.finer_levels = 1;
            HybridPixel other;
            cast_stage({finer, view, x, y}, other);
            ASSERT_EQ(other.color(),
                      scene_.color[color_index(tree_, leaf, std::max(0, level - 1))]);
        }
    }
    EXPECT_TRUE(coarse) << "a test that sees voxels only";
}

TEST_F(HybridTest, ThePriceDecidesFromOneRayToAllOfThem) {
    const uint64_t pixels = owned_pixel_count(kSize);
    EXPECT_EQ(render(settings(kNever)).total().all_rays(), pixels);
    EXPECT_EQ(render(settings(-1.0, 4)).total().rays, pixels * (1 + 4 + 16));
    EXPECT_EQ(render(settings(-1.0)).total().rays, pixels * (1 + 4 + 256));
    EXPECT_EQ(render(settings(-1.0)).total().discarded_rays, 0u);
    uint64_t steps = 0;
    double error = kNever;
    for (const double price : {1e-3, 1e-4, 1e-5, 1e-6}) {
        const CubemapRender cube = render(settings(price));
        EXPECT_GT(cube.total().steps, steps) << price;
        EXPECT_LT(error_of(cube.color), error) << price;
        steps = cube.total().steps;
        error = error_of(cube.color);
    }
}

TEST_F(HybridTest, ARecordReplaysWhatTheRendererDoes) {
    for (const double price : {1e-3, 1e-5, 1e-7, -1.0}) {
        for (const int grid : {4, 8, 16}) {
            const RenderSettings with = settings(price, grid);
            const CubemapRender cube = render(with);
            CostStats replayed;
            for (const CubeFace face : kCubeFaces) {
                const View view = cube_face_view(face, kSize, test::kSmallWorldProbe);
                const auto owned = [&](int x, int y) {
                    const CubePixel pixel{face, x, y};
                    return x >= 0 && y >= 0 && x < kSize && y < kSize &&
                           owner_of(pixel, kSize) == pixel;
                };
                for (int y = 0; y < kSize; ++y) {
                    for (int x = 0; x < kSize; ++x) {
                        if (!owned(x, y)) continue;
                        std::array<Neighbour, 9> block;
                        for (int i = 0; i < 9; ++i) {
                            const int nx = x + i % 3 - 1;
                            const int ny = y + i / 3 - 1;
                            if (!owned(nx, ny)) continue;
                            HybridPixel near;
                            cast_stage({scene_, view, nx, ny}, near);
                            block[static_cast<size_t>(i)] = {near.color(), true};
                        }
                        const double contrast = neighbour_contrast(block);
                        HybridRecord record;
                        record.pixel.evidence.contrast = contrast;
                        CostStats casts;
                        for (int stage = 0; stage_grid(stage) <= grid && stage < kHybridStages;
                             ++stage) {
                            record_stage({scene_, view, x, y}, record, casts);
                        }
                        const ReplayedPixel pixel = replay_hybrid(record, with);
                        ASSERT_EQ(Rgb(pixel.color), cube.color.at({face, x, y}));
                        replayed.rays += pixel.rays;
                        replayed.steps += pixel.steps;
                        CostStats alone;
                        const PixelSums sums =
                            hybrid_pixel({scene_, view, x, y}, contrast, with, alone);
                        ASSERT_EQ(sums.color, pixel.color);
                        ASSERT_EQ(alone.all_rays(), pixel.rays);
                    }
                }
            }
            EXPECT_EQ(replayed.rays, cube.total().all_rays());
            EXPECT_GT(replayed.steps, cube.total().steps) << "tiles share a start list";
        }
    }
}

/// Start lists change what a ray costs, never what it sees.
TEST_F(HybridTest, StartListsChangeNothingButTheSteps) {
    for (const double price : {kNever, 1e-4, -1.0}) {
        RenderSettings without = settings(price);
        without.hybrid.start_lists = false;
        const CubemapRender listed = render(settings(price));
        const CubemapRender plain = render(without);
        EXPECT_TRUE(listed.color == plain.color);
        EXPECT_EQ(listed.total().all_rays(), plain.total().all_rays());
        EXPECT_EQ(listed.total().level_histogram, plain.total().level_histogram);
        EXPECT_LT(listed.total().steps, plain.total().steps);
        EXPECT_GT(listed.total().box_tests, 0u);
        EXPECT_EQ(plain.total().box_tests, 0u);
    }
}

/// Rays that stay where they are, against as many stages of rays that replace each other.
TEST_F(HybridTest, NestedRaysAreFewerAndBetter) {
    for (const int grid : {2, 4, 8, 16}) {
        RenderSettings replaced = settings(-1.0, grid);
        replaced.hybrid.nested_rays = false;
        const CubemapRender nested = render(settings(-1.0, grid));
        const CubemapRender regular = render(replaced);
        EXPECT_LE(nested.total().all_rays(), regular.total().all_rays());
        EXPECT_LT(error_of(nested.color), error_of(regular.color)) << grid;
        EXPECT_EQ(regular.total().rays, owned_pixel_count(kSize) * static_cast<uint64_t>(grid) *
                                            static_cast<uint64_t>(grid));
    }
}

TEST_F(HybridTest, ARayLimitIsSpentWhereMostIsPredicted) {
    const CubemapRender all = render(settings(1e-7));
    double error = kNever;
    for (const double share : {0.1, 0.3, 0.6}) {
        const auto limit =
            static_cast<uint64_t>(share * static_cast<double>(all.total().all_rays()));
        const CubemapRender limited = render(settings(1e-7), limit);
        EXPECT_TRUE(limited.limited);
        EXPECT_LE(limited.total().all_rays(), limit);
        EXPECT_GT(limited.total().all_rays() + uint64_t{6} * 192, limit) << "and it is spent";
        EXPECT_LT(error_of(limited.color), error);
        error = error_of(limited.color);
    }
    // The limit is shared among the faces: enough for each of them.
    const CubemapRender enough = render(settings(1e-7), 3 * all.total().all_rays());
    EXPECT_FALSE(enough.limited);
    EXPECT_EQ(enough.total().all_rays(), all.total().all_rays());
    EXPECT_TRUE(enough.color == all.color);
}

TEST_F(HybridTest, SeesThatARaySlippedPastSomething) {
    // A thin bar far away before nothing: the middle of every pixel beside it misses it.
    VoxelCloud cloud;
    cloud.depth = 8;
    for (int x = 0; x < 256; ++x)
        cloud.voxels.push_back(make_voxel({x, 110, 10}, pack_rgb(Rgb(1.0f))));
    const VoxelTree tree = VoxelTree::build(std::move(cloud));
    const RenderScene scene{.tree = tree, .color = tree.colors().albedo};
    const View view = cube_face_view(CubeFace::kNegZ, 16, {128.3, 100.5 + 8.0, 250.7});
    int slipped = 0;
    int seen = 0;
    for (int y = 0; y < 16; ++y) {
        CostStats stats;
        HybridPixel first;
        cast_stage({scene, view, 8, y}, first);
        const float truth = uniform_pixel(scene, view, 8, y, 64, stats).mean().g;
        if (first.cost.missed_rays == 0 || truth < 0.01f) continue;
        ++slipped;
        PixelEvidence evidence = first.evidence;  // its neighbours miss as well
        if (predicted_error(0, evidence) > 1e-4) ++seen;
        evidence.passed_contrast = {};
        EXPECT_EQ(predicted_error(0, evidence), 0.0);
    }
    EXPECT_GT(slipped, 0);
    EXPECT_GT(seen, 0) << "unless the bar lies in no node that the ray meets";
}

TEST_F(HybridTest, RefinedInStepsItIsWhatItsLastPriceMakesOfIt) {
    HybridCubemap steps(scene_, test::kSmallWorldProbe, kSize, cancel_);
    for (const double price : {1e-2, 1e-3, 3e-4, 1e-5}) {
        steps.refine_to(price);
        const CubemapRender refined = steps.render();
        const CubemapRender direct = render(settings(price));
        ASSERT_TRUE(refined.color == direct.color) << price;
        EXPECT_EQ(refined.total().rays, direct.total().rays);
        EXPECT_EQ(refined.total().steps, direct.total().steps);
        EXPECT_EQ(refined.total().box_tests, direct.total().box_tests);
        EXPECT_EQ(refined.pixels, direct.pixels);
        double sum = 0.0;
        std::vector<double> weights(direct.aux.size());
        for (size_t i = 0; i < weights.size(); ++i) {
            const CubePixel pixel = pixel_at(i, kSize);
            if (owner_of(pixel, kSize) != pixel) continue;
            weights[i] = 1.0;
            sum += static_cast<double>(direct.aux[i].predicted_error);
        }
        EXPECT_NEAR(steps.predicted_sum(weights), sum, 1e-9);
        EXPECT_LE(steps.largest_gain(), price);
    }
}

TEST_F(HybridTest, EveryPixelGetsTheLeastGridWhateverIsPredictedOfIt) {
    HybridCubemap steps(scene_, test::kSmallWorldProbe, kSize, cancel_);
    double error = 1e30;
    for (const int least : {1, 4, 16}) {
        RenderSettings with = settings(1e-3);
        with.least_grid = least;
        const CubemapRender direct = render(with);
        steps.refine_to(1e-3, least);
        const CubemapRender refined = steps.render();
        ASSERT_TRUE(refined.color == direct.color) << least;
        EXPECT_EQ(refined.total().rays, direct.total().rays);
        const uint64_t pixels =
            std::accumulate(refined.pixels.begin(), refined.pixels.end(), uint64_t{0});
        EXPECT_GE(refined.total().rays, static_cast<uint64_t>(least * least) * pixels);
        EXPECT_LT(error_of(direct.color), error);
        error = error_of(direct.color);
    }
}

}  // namespace
}  // namespace probebake
