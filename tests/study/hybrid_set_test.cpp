#include "study/beyond/hybrid_set.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/render.h"
#include "render/render_fixture.h"
#include "study/beyond/error_fit.h"

namespace probebake::study {
namespace {

class HybridSetTest : public testing::Test {
  protected:
    static constexpr int kSize = 12;

    HybridSet record(const HybridSwitches& switches) const {
        std::vector<Image> truth;
        for (const FaceView& view : views_) truth.push_back(nested_truth(scene_, view));
        return {scene_, views_, truth, switches};
    }

    VoxelTree tree_ = test::small_world();
    RenderScene scene_{.tree = tree_, .color = tree_.colors().albedo, .background = Rgb(0.1f)};
    std::vector<FaceView> views_ = cubemap_views(std::array{test::kSmallWorldProbe}, kSize);
};

TEST_F(HybridSetTest, CostsAndErrsAsTheRendererDoes) {
    for (const HybridSwitches& switches :
         {HybridSwitches{}, HybridSwitches{.start_lists = false},
          HybridSwitches{.start_lists = false, .nested_rays = false}}) {
        const HybridSet set = record(switches);
        for (const double price : {1e9, 1e-3, 1e-5, -1.0}) {
            const RenderSettings settings{
                .kind = RendererKind::kHybrid, .leaf_grid = 8, .price = price, .hybrid = switches};
            const CubemapRender render =
                render_cubemap(scene_, test::kSmallWorldProbe, kSize, settings, CancelToken());
            const HybridOutcome outcome = set.outcome(model_score(), price);
            EXPECT_EQ(outcome.pixels, owned_pixel_count(kSize));
            EXPECT_EQ(outcome.rays, render.total().all_rays()) << price;
            EXPECT_EQ(outcome.steps, render.total().steps) << price;
            EXPECT_EQ(outcome.box_tests, render.total().box_tests) << price;
            double squared = 0.0;
            for (const FaceView& at : views_) {
                const Image truth = nested_truth(scene_, at);
                for (int y = 0; y < kSize; ++y) {
                    for (int x = 0; x < kSize; ++x) {
                        if (!at.renders(x, y)) continue;
                        const Vec3 d(render.color.at({*at.face, x, y}) - truth.at(x, y));
                        squared += glm::dot(d, d) / 3.0;
                    }
                }
            }
            EXPECT_NEAR(outcome.mse, squared / static_cast<double>(outcome.pixels), 1e-6);
        }
    }
}

TEST_F(HybridSetTest, PricesAreFoundForStepsAndForErrors) {
    const HybridSet set = record({});
    const uint64_t least = set.outcome(model_score(), 1e9).steps;
    const uint64_t most = set.outcome(model_score(), -1.0).steps;
    const HybridOutcome half = set.within_steps(model_score(), (least + most) / 2);
    EXPECT_LE(half.steps, (least + most) / 2);
    EXPECT_GT(half.steps, least + (most - least) * 4 / 10);
    EXPECT_EQ(set.within_steps(model_score(), 2 * most).steps, most);
    EXPECT_EQ(set.within_steps(model_score(), 1).steps, least);
    const double price = set.price_for_error(model_score(), half.rmse());
    EXPECT_LE(set.outcome(model_score(), price).rmse(), half.rmse());
    EXPECT_LE(set.outcome(model_score(), price).steps, half.steps);
    EXPECT_LT(set.price_for_error(model_score(), 0.0), 0.0);
    // A score that knows the errors does at least as well.
    EXPECT_LE(set.within_steps(perfect_score(), (least + most) / 2).rmse(), half.rmse());
}

TEST(ErrorFit, FindsTheCoefficientsThatMadeTheErrors) {
    // Errors of exponential distribution around known sums of log-uniform terms.
    const std::array<double, 3> known = {0.3, 0.0, 0.08};
    std::vector<RecordedPixel> pixels(40'000);
    RandomStream random(random_key({99}));
    for (RecordedPixel& pixel : pixels) {
        const auto term = [&] { return std::exp(8.0 * random.uniform() - 8.0); };
        pixel.evidence.contrast = term();
        pixel.evidence.child_variance[0] = term();
        pixel.evidence.node_error[0] = random.uniform();
        const double mean =
            known[0] * pixel.evidence.contrast + known[2] * pixel.evidence.child_variance[0];
        const double squared = -mean * std::log(1.0 - random.uniform());
        pixel.stages[0].color = Vec3(std::sqrt(squared));
    }
    const std::vector<std::vector<RecordedPixel>> scenes = {pixels};
    const ErrorModel fitted = fit_error_model(scenes, kErrorModel);
    EXPECT_NEAR(fitted[0][0], known[0], 0.02);
    EXPECT_LT(fitted[0][1], 0.04);
    EXPECT_NEAR(fitted[0][2], known[2], 0.01);
    EXPECT_EQ(fitted[0][3], 0.0) << "a term that never was";
}

}  // namespace
}  // namespace probebake::study
