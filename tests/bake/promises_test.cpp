// Promises of SSIM against the truth: a job that is judged by few windows of each probe, and by
// all of them together.
#include <gtest/gtest.h>

#include <algorithm>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "bake/learn.h"
#include "image/exr.h"
#include "image/metrics.h"
#include "render/render.h"

namespace probebake {
namespace {

constexpr int kProbes = 48;
constexpr double kTarget = 0.9;

JobSpec ssim_job() {
    Json request = test::small_request(1, {{"ssim", kTarget}});
    const Scene scene = test::small_scene();
    request["probes"]["list"].clear();
    for (int i = 0; i < kProbes; ++i) {
        const int level = i / 4 % 3;
        const int row = i / 12;
        const Vec3 offset(1.3 * (i % 4), 1.1 * level, -1.7 * row);
        const Vec3 p = scene.to_metres(test::kSmallWorldProbe + offset);
        request["probes"]["list"].push_back(
            {{"id", "p" + std::to_string(i)}, {"position_m", {p.x, p.y, p.z}}});
    }
    return read_job(request);
}

TEST(Promises, OfSsimHold) {
    const Scene scene = test::small_scene();
    const JobSpec job = ssim_job();
    const CancelToken cancel;
    Pilot pilot = run_pilot(scene, job, make_plan(scene, job), LightingState::kAlbedo, cancel);
    const size_t first = probes_to_learn_from(job);
    ASSERT_EQ(first, 16u);
    std::vector<ProbeResult> results;
    for (size_t i = 0; i < first; ++i) {
        results.push_back(bake_probe(scene, job, pilot, {.probe = i, .teaches = true}, cancel));
    }
    learn(pilot, job.quality, results);
    for (size_t i = first; i < job.probes.size(); ++i) {
        results.push_back(bake_probe(scene, job, pilot, {.probe = i}, cancel));
    }
    int promised = 0;
    int kept = 0;
    int with_windows = 0;
    double least = 1.0;
    for (const ProbeResult& result : results) {
        with_windows += result.certificate.windows > 0 ? 1 : 0;
        if (!result.target_met) continue;
        ++promised;
        const ProbeSpec& probe = job.probes[result.probe];
        const CubemapRender truth = render_cubemap(
            render_scene(scene, probe, pilot.state), scene.to_voxels(probe.position_m),
            probe.face_size_px, {.kind = RendererKind::kReference, .leaf_grid = 24}, cancel);
        const Cubemap cube = decode_cubemap(result.files[0].bytes, "cube.exr").cubemap;
        const double ssim = *compare_cubemaps(cube, truth.color, pilot.exposure).cube.ssim;
        kept += ssim >= kTarget ? 1 : 0;
        least = std::min(least, ssim);
    }
    std::printf("%d of %d promised; %d kept, the least %.3f; %d audited by windows of their own\n",
                promised, kProbes, kept, least, with_windows);
    EXPECT_EQ(promised, kProbes);
    // With 95 % kept, fewer than 41 of 48 would be by chance in 0.5 % of all cases.
    EXPECT_GE(kept, 41);
    EXPECT_LT(with_windows, kProbes) << "else the job's windows tell nothing about the others";
}

}  // namespace
}  // namespace probebake
