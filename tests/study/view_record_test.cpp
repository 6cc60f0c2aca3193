#include "study/view_record.h"

#include <gtest/gtest.h>

#include "render/render.h"
#include "render/render_fixture.h"
#include "study/record_set.h"

namespace probebake::study {
namespace {

class ViewRecordTest : public testing::Test {
  protected:
    VoxelTree tree_ = test::small_world();
    RenderScene scene_{.tree = tree_, .color = tree_.colors().albedo};
    View view_ = perspective_view({.origin = {31.3, 80.2, 30.7},
                                   .vertical_fov_degrees = 60.0,
                                   .width_px = 24,
                                   .height_px = 24});
    CancelToken cancel_;

    void expect_same(const ViewRecord& record, const Outcome& outcome,
                     const RenderSettings& settings) const {
        const ViewRender render = render_view(scene_, view_, settings, cancel_);
        Counts counts;
        for (size_t i = 0; i < record.pixels.size(); ++i) {
            const PixelOutcome pixel = outcome(record.pixels[i]);
            counts.add(pixel);
            for (int c = 0; c < 3; ++c) {
                ASSERT_NEAR(pixel.color[c], render.color.pixels()[i][c], 1e-6) << i;
            }
        }
        EXPECT_EQ(counts.rays, render.stats.all_rays());
        EXPECT_EQ(counts.discarded_rays, render.stats.discarded_rays);
        EXPECT_EQ(counts.steps, render.stats.steps);
        EXPECT_EQ(counts.classes[0] + counts.classes[1] + counts.classes[2] + counts.classes[3],
                  counts.pixels);
    }
};

TEST_F(ViewRecordTest, IsWhatTheRenderersRender) {
    for (const auto& level : {std::optional<int>(), std::optional<int>(2)}) {
        const ViewRecord record = record_view(scene_, view_, {.fixed_level = level});
        expect_same(record, lod_outcome, {.kind = RendererKind::kLod, .fixed_level = level});
        expect_same(record, reference_outcome, {.kind = RendererKind::kReference});
        for (const double threshold : {-1.0, 0.05, 0.154, 0.5, 2.0}) {
            for (const double decay : {0.0, 0.2, 0.7}) {
                expect_same(
                    record,
                    [&](const PixelRecord& p) { return error_aware_outcome(p, threshold, decay); },
                    {.threshold = threshold, .decay = decay, .fixed_level = level});
            }
        }
        for (const double normaliser : {0.01, 0.1, 1.0}) {
            for (const auto misses : {MissesInKernel::kLeftOut, MissesInKernel::kBlack}) {
                expect_same(
                    record,
                    [&](const PixelRecord& p) { return adaptive_outcome(p, normaliser, misses); },
                    {.kind = RendererKind::kAdaptive,
                     .fixed_level = level,
                     .normaliser = normaliser,
                     .misses_in_kernel = misses});
            }
        }
    }
}

TEST_F(ViewRecordTest, MissesAreNotCountedAsHits) {
    View away = view_;
    away.forward = -away.forward;
    const RecordSet nothing(scene_, away);
    const Counts counts = nothing.count(reference_outcome);
    EXPECT_EQ(counts.rays, 24u * 24u * 16u);
    EXPECT_EQ(counts.hit_rays, 0u);
    EXPECT_EQ(counts.classes[0], 24u * 24u);
    EXPECT_EQ(counts.rays_per_hit_pixel(), 0.0);
}

TEST_F(ViewRecordTest, BudgetsOfStepsAreKeptAndUsed) {
    const RecordSet set(scene_, view_);
    const uint64_t base = set.count(lod_outcome).steps;
    for (const double budget : {1.5, 3.0, 6.0}) {
        const auto steps = static_cast<uint64_t>(budget * static_cast<double>(base));
        const double threshold = set.threshold_for_steps(steps, 0.2);
        const auto error_aware = [&](double t) {
            return set.count([&](const PixelRecord& p) { return error_aware_outcome(p, t, 0.2); })
                .steps;
        };
        EXPECT_LE(error_aware(threshold), steps);
        EXPECT_GT(error_aware(threshold - 1e-6), steps);
        for (const auto misses : {MissesInKernel::kLeftOut, MissesInKernel::kBlack}) {
            const double normaliser = set.normaliser_for_steps(steps, misses);
            const auto adaptive = [&](double n) {
                return set
                    .count([&](const PixelRecord& p) { return adaptive_outcome(p, n, misses); })
                    .steps;
            };
            EXPECT_LE(adaptive(normaliser), steps);
            EXPECT_GT(adaptive(normaliser * (1.0 - 1e-6)), steps);
        }
    }
    EXPECT_EQ(set.normaliser_for_steps(base - 1, MissesInKernel::kLeftOut),
              std::numeric_limits<double>::infinity());
}

TEST_F(ViewRecordTest, CubemapsCountSharedPixelsOnce) {
    const std::vector<Vec3> positions = {test::kSmallWorldProbe};
    const RecordSet set(scene_, positions, 16);
    EXPECT_EQ(set.count(lod_outcome).pixels, owned_pixel_count(16));
    const Measured measured = set.measure(reference_outcome);
    EXPECT_EQ(measured.against_reference.rmse, 0.0);
    EXPECT_FALSE(measured.against_reference.psnr_db().has_value());
    EXPECT_GT(measured.against_truth.rmse, 0.0);
    EXPECT_LT(measured.against_truth.rmse, set.measure(lod_outcome).against_truth.rmse);
    const CubemapRender render =
        render_cubemap(scene_, positions[0], 16, {.kind = RendererKind::kErrorAware}, cancel_);
    const Counts counts = set.count([](const PixelRecord& p) {
        return error_aware_outcome(p, kThesisThreshold, kThesisDecay);
    });
    EXPECT_EQ(counts.rays, render.total().all_rays());
    EXPECT_EQ(counts.steps, render.total().steps);
}

}  // namespace
}  // namespace probebake::study
