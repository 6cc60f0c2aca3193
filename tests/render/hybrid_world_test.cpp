// The hybrid renderer beside the thesis's method, on worlds that nothing was fitted on.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "render/render.h"
#include "scene/generators/generators.h"
#include "scene/suggest_probes.h"

namespace probebake {
namespace {

constexpr int kSize = 32;

struct World {
    explicit World(const char* generator) {
        scene.tree = VoxelTree::build(generate({generator, 256, 77}));
        scene.voxel_size_m = 2.0;
        probe = scene.to_voxels(suggest_probes(scene, 1, 5).at(0));
    }
    CubemapRender render(const RenderSettings& settings) const {
        return render_cubemap({.tree = scene.tree, .color = scene.tree.colors().albedo}, probe,
                              kSize, settings, CancelToken());
    }

    Scene scene;
    Vec3 probe{0.0};
};

double rmse(const Cubemap& a, const Cubemap& b) {
    double sum = 0.0;
    const std::span<const Rgb> pixels = a.image().pixels();
    for (size_t i = 0; i < pixels.size(); ++i) {
        const Vec3 d(pixels[i] - b.image().pixels()[i]);
        sum += glm::dot(d, d) / 3.0;
    }
    return std::sqrt(sum / static_cast<double>(pixels.size()));
}

/// The hybrid of the lowest price that costs no more steps.
CubemapRender hybrid_within(const World& world, uint64_t steps) {
    CubemapRender best{.color = Cubemap(kSize)};
    for (double price = 1.0;; price /= 1.5) {
        CubemapRender next =
            world.render({.kind = RendererKind::kHybrid, .leaf_grid = 16, .price = price});
        if (next.total().steps > steps) return best;
        best = std::move(next);
    }
}

TEST(HybridWorld, BeatsTheThesissMethodAtEqualSteps) {
    double log_sum = 0.0;
    int count = 0;
    for (const char* generator : {"desert", "forest", "mountain", "biomes"}) {
        const World world(generator);
        const Cubemap truth =
            world.render({.kind = RendererKind::kReference, .leaf_grid = 16}).color;
        for (const double threshold : {0.6, 0.154}) {
            const CubemapRender thesis = world.render({.threshold = threshold});
            const CubemapRender hybrid = hybrid_within(world, thesis.total().steps);
            ASSERT_GT(hybrid.total().rays, 0u);
            const double ratio = rmse(hybrid.color, truth) / rmse(thesis.color, truth);
            std::printf("%-9s threshold %.3f: RMSE ratio %.3f at %.2f of the steps\n", generator,
                        threshold, ratio,
                        static_cast<double>(hybrid.total().steps) /
                            static_cast<double>(thesis.total().steps));
            EXPECT_LT(ratio, 1.0) << generator;
            log_sum += std::log(ratio);
            ++count;
        }
    }
    EXPECT_LT(std::exp(log_sum / count), 0.8);
}

}  // namespace
}  // namespace probebake
