#include "scatter/volume_cubemap.h"

#include <tbb/global_control.h>

#include "scatter/scatter_fixture.h"

namespace probebake {
namespace {

using test::World;

World cloud_over_ground() {
    World world;
    world.tree = VoxelTree::build(test::flat_ground(6, Rgb(0.5f)));
    world.corner_m = {-32.0, -10.0, -32.0};
    world.media = Media({{.name = "cloud",
                          .absorption_per_m = Rgb(0.1f),
                          .scattering_per_m = Rgb(0.4f, 0.6f, 0.9f),
                          .g = 0.5,
                          .shape = test::noise_cloud()}});
    world.lighting.sun = Sun{.direction = {1, 2, 0.5}, .irradiance = Rgb(3.0f)};
    world.lighting.sky = Sky(SkyGradient{Rgb(0.2f, 0.4f, 1.0f), Rgb(1.0f), Rgb(0.1f)});
    return world;
}

const VolumeView kView{.origin_m = {0.0, -8.0, 0.0}, .face_size_px = 12, .range = {0.0, 1000.0}};

double rmse(const Cubemap& a, const Cubemap& b) {
    double sum = 0.0;
    const auto pa = a.image().pixels();
    const auto pb = b.image().pixels();
    for (size_t i = 0; i < pa.size(); ++i) {
        const Vec3 d = Vec3(pa[i]) - Vec3(pb[i]);
        sum += glm::dot(d, d) / 3.0;
    }
    return std::sqrt(sum / static_cast<double>(pa.size()));
}

TEST(VolumeCubemap, MeetsItsTargetWhereTheVarianceIs) {
    const World world = cloud_over_ground();
    const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
    const CancelToken cancel;
    VolumeQuality quality{.target_rmse = 0.05};
    VolumeView view = kView;
    const VolumeCubemap a = render_volume_cubemap(tracer, view, quality, cancel);
    view.key = 2;
    const VolumeCubemap b = render_volume_cubemap(tracer, view, quality, cancel);
    EXPECT_TRUE(a.target_met);
    EXPECT_LE(a.predicted_rmse, quality.target_rmse);
    EXPECT_GT(a.rounds, 1);
    EXPECT_EQ(a.count().all_faults(), 0u);
    // Two independent renders: their difference has twice the squared error. Sobol points make it
    // smaller than predicted, never larger.
    const double measured = rmse(a.color, b.color) / std::sqrt(2.0);
    EXPECT_LT(measured, 1.15 * quality.target_rmse);
    EXPECT_GT(measured, 0.4 * quality.target_rmse);
    // The least cost is less than that of equal samples.
    uint64_t most = 0;
    uint64_t sum = 0;
    double equal = 0.0;
    for (const VolumePixel& pixel : a.pixels) {
        most = std::max(most, static_cast<uint64_t>(pixel.samples));
        sum += static_cast<uint64_t>(pixel.samples);
        const Vec3 e(pixel.standard_error);
        equal += glm::dot(e, e) / 3.0 * pixel.samples;
    }
    const auto pixels = static_cast<double>(a.pixels.size());
    const double uniform = equal / (pixels * quality.target_rmse * quality.target_rmse) * pixels;
    EXPECT_LT(static_cast<double>(sum), uniform);
    EXPECT_GT(most, 2 * sum / a.pixels.size());
}

TEST(VolumeCubemap, IsTheSameForAnyNumberOfThreads) {
    const World world = cloud_over_ground();
    const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
    const CancelToken cancel;
    const VolumeQuality quality{.target_rmse = 0.2};
    const VolumeCubemap parallel = render_volume_cubemap(tracer, kView, quality, cancel);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const VolumeCubemap single = render_volume_cubemap(tracer, kView, quality, cancel);
    EXPECT_EQ(parallel.color, single.color);
    EXPECT_EQ(parallel.count(), single.count());
}

TEST(VolumeCubemap, StopsAtItsBudget) {
    const World world = cloud_over_ground();
    const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
    const CancelToken cancel;
    const VolumeQuality quality{.target_rmse = 1e-4, .most_paths = 40000};
    const VolumeCubemap cube = render_volume_cubemap(tracer, kView, quality, cancel);
    EXPECT_FALSE(cube.target_met);
    EXPECT_LE(cube.count().paths, 40000u);
    CancelToken stop;
    stop.cancel();
    EXPECT_THROW(render_volume_cubemap(tracer, kView, quality, stop), Cancelled);
}

TEST(VolumeCubemap, SharedPixelsHoldTheSame) {
    const World world = cloud_over_ground();
    const PathTracer tracer(world.scene(), choose_tracker(facts_of(world.media)));
    const CancelToken cancel;
    const VolumeCubemap cube = render_volume_cubemap(tracer, kView, {}, cancel);
    for_each_shared_pixel(kView.face_size_px, [&](const CubePixel& pixel, const CubePixel& owner) {
        EXPECT_EQ(cube.color.at(pixel), cube.color.at(owner));
    });
    EXPECT_EQ(cube.count().paths, 16 * owned_pixel_count(kView.face_size_px));
}

}  // namespace
}  // namespace probebake
