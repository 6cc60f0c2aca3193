#include "render/error_aware.h"

#include <gtest/gtest.h>

#include <limits>

#include "render/render_fixture.h"

namespace probebake {
namespace {

class ErrorAwareTest : public testing::Test {
  protected:
    template <class Check>
    void for_each_pixel(Check check) {
        for (const CubeFace face : kCubeFaces) {
            const View view = cube_face_view(face, 12, test::kSmallWorldProbe);
            for (int y = 0; y < 12; ++y) {
                for (int x = 0; x < 12; ++x) check(view, x, y);
            }
        }
    }

    VoxelTree tree_ = test::small_world();
    RenderScene scene_{.tree = tree_, .color = tree_.colors().albedo, .background = Rgb(0.1f)};
};

void expect_near(const Vec3& got, const Vec3& expected) {
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(got[c], expected[c], 1e-12);
}

TEST_F(ErrorAwareTest, WithoutRefinementItIsTheLodRenderer) {
    RenderSettings settings{.threshold = std::numeric_limits<double>::infinity()};
    for_each_pixel([&](const View& view, int x, int y) {
        CostStats stats;
        CostStats lod_stats;
        const PixelSums sums = error_aware_pixel(scene_, view, x, y, settings, stats);
        const PixelSums lod = lod_pixel(scene_, view, x, y, settings, lod_stats);
        ASSERT_EQ(sums.color, lod.color);
        ASSERT_EQ(stats.all_rays(), 1u);
        ASSERT_EQ(stats.steps, lod_stats.steps);
    });
}

TEST_F(ErrorAwareTest, FullRefinementIsTheReferenceAfterTheDiscardedRays) {
    for (const int grid : kLeafGrids) {
        // A spread below 0 goes on everywhere.
        const RenderSettings settings{.threshold = -1.0, .leaf_grid = grid, .spread = -1.0};
        uint64_t discarded = 5;
        for (int coarser = 4; coarser < grid; coarser *= 2) {
            discarded += static_cast<uint64_t>(coarser * coarser);
        }
        for_each_pixel([&](const View& view, int x, int y) {
            CostStats stats;
            CostStats reference_stats;
            const PixelSums sums = error_aware_pixel(scene_, view, x, y, settings, stats);
            const PixelSums reference = uniform_pixel(scene_, view, x, y, grid, reference_stats);
            expect_near(sums.color, reference.color);
            ASSERT_EQ(stats.rays, reference_stats.rays);
            ASSERT_EQ(stats.discarded_rays, discarded);
        });
    }
}

TEST_F(ErrorAwareTest, GoesOnExactlyWhereTheRaysSpread) {
    const RenderSettings thesis{.threshold = 0.05};
    RenderSettings settings = thesis;
    settings.leaf_grid = 16;
    settings.spread = 0.035;
    int stages[3] = {};
    for_each_pixel([&](const View& view, int x, int y) {
        CostStats thesis_stats;
        const PixelSums sums = error_aware_pixel(scene_, view, x, y, thesis, thesis_stats);
        uint64_t rays = thesis_stats.all_rays();
        int stage = 0;
        if (rays > 1 && sums.spread() > settings.spread) {
            CostStats ignored;
            stage = 1;
            rays += 64;
            if (uniform_pixel(scene_, view, x, y, 8, ignored).spread() > settings.spread) {
                stage = 2;
                rays += 256;
            }
        }
        CostStats stats;
        error_aware_pixel(scene_, view, x, y, settings, stats);
        ASSERT_EQ(stats.all_rays(), rays);
        ASSERT_EQ(stats.rays, stage == 0 ? thesis_stats.rays : stage == 1 ? 64u : 256u);
        ++stages[stage];
    });
    for (const int count : stages) EXPECT_GT(count, 10);
}

TEST_F(ErrorAwareTest, RefinesExactlyWhereTheNodesErrorExceedsTheThreshold) {
    // The tree of decisions, followed by hand with the traversal and the table.
    const RenderSettings settings{.threshold = 0.154, .decay = 0.2};
    uint64_t ones = 0;
    uint64_t fours = 0;
    uint64_t more = 0;
    for_each_pixel([&](const View& view, int x, int y) {
        CostStats stats;
        error_aware_pixel(scene_, view, x, y, settings, stats);
        const auto error_at = [&](double px, double py, double pixels) {
            const PixelRay cast = pixel_ray(view, px, py, pixels);
            const Hit hit = trace(tree_, cast.ray, {.cone = cast.cone});
            if (!hit || hit.level == 0) return 0.0;
            const ChildMasks masks = child_masks(tree_, hit);
            double error = thesis_error_table().error(cast.ray.direction, masks.own);
            for (int c = 0; c < masks.child_count; ++c) {
                error += settings.decay / masks.child_count *
                         thesis_error_table().error(cast.ray.direction,
                                                    masks.children[static_cast<size_t>(c)]);
            }
            return error;
        };
        uint64_t rays = 1;
        if (error_at(x, y, 1.0) > settings.threshold) {
            rays += 4;
            for (int q = 0; q < 4; ++q) {
                const int column = q % 2;
                const int row = q / 2;
                if (error_at(x - 0.25 + 0.5 * column, y - 0.25 + 0.5 * row, 0.5) >
                    settings.threshold) {
                    rays += 4;
                }
            }
        }
        ASSERT_EQ(stats.all_rays(), rays);
        ASSERT_LE(rays, 21u);
        ++(rays == 1 ? ones : rays == 5 ? fours : more);
    });
    EXPECT_GT(ones, 20u);  // the world offers every kind of decision
    EXPECT_GT(fours, 20u);
    EXPECT_GT(more, 20u);
}

TEST_F(ErrorAwareTest, AReplayedRecordIsTheRender) {
    for_each_pixel([&](const View& view, int x, int y) {
        CostStats pilot;
        RefinementRecord record = record_refinement(scene_, view, x, y, {}, pilot);
        for (const int grid : kLeafGrids) {
            record_leaves(scene_, view, x, y, grid, record, pilot);
        }
        ASSERT_EQ(pilot.all_rays(), 1u + 4u + 16u + 64u + 256u);
        const auto expect_same = [](const ReplayedPixel& replayed, const PixelSums& sums,
                                    const CostStats& stats) {
            expect_near(replayed.color, sums.color);
            ASSERT_EQ(replayed.rays, stats.all_rays());
            ASSERT_EQ(replayed.steps, stats.steps);
        };
        for (const int grid : kLeafGrids) {
            for (const double threshold : {1e9, 0.6, 0.154, 0.05, -1.0}) {
                for (const double spread : {0.02, 0.06, 1e9}) {
                    const RenderSettings settings{
                        .threshold = threshold, .leaf_grid = grid, .spread = spread};
                    CostStats stats;
                    const PixelSums sums = error_aware_pixel(scene_, view, x, y, settings, stats);
                    expect_same(replay_error_aware(record, settings), sums, stats);
                }
            }
            CostStats stats;
            const PixelSums sums = uniform_pixel(scene_, view, x, y, grid, stats);
            expect_same(replay_reference(record, grid), sums, stats);
            if (grid == 4) {
                EXPECT_NEAR(leaf_spread(record), sums.spread(), 1e-9);
            }
        }
    });
}

TEST_F(ErrorAwareTest, AFixedLevelOfDetailGoesOneLevelDownPerRefinement) {
    RenderSettings settings{.threshold = std::numeric_limits<double>::infinity(), .fixed_level = 2};
    const View view = cube_face_view(CubeFace::kNegY, 16, test::kSmallWorldProbe);
    CostStats stats;
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) error_aware_pixel(scene_, view, x, y, settings, stats);
    }
    EXPECT_EQ(stats.level_histogram[2], stats.hits());
    settings.threshold = 0.154;
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) error_aware_pixel(scene_, view, x, y, settings, stats);
    }
    EXPECT_GT(stats.level_histogram[1], 0u);
    EXPECT_GT(stats.level_histogram[0], 0u);
}

}  // namespace
}  // namespace probebake
