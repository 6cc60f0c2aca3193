// What directed rays find, against rays everywhere; and that bakes do not overlook it.
#include "bake/hidden_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "bake/probe_view.h"
#include "image/exr.h"

namespace probebake {
namespace {

constexpr int kFace_px = 8;

/// A wall around the world but for some holes, and lamps in it.
VoxelCloud walls_with_lamps() {
    VoxelCloud cloud;
    cloud.depth = 5;
    RandomStream random(3);
    const auto add = [&](const IVec3& at) {
        const bool hole = random.uniform() < 0.03;
        const bool lamp = random.uniform() < 0.003;
        const Rgb light = lamp ? Rgb(40.0f, 20.0f, 10.0f) : Rgb(0.0f);
        if (!hole) cloud.voxels.push_back(make_voxel(at, pack_rgb(Rgb(0.5f)), pack_rgb(light)));
    };
    for (int a = 0; a < 32; ++a) {
        for (int b = 0; b < 32; ++b) {
            for (const int wall : {0, 31}) {
                add({wall, a, b});
                if (a > 0 && a < 31) add({a, wall, b});
                if (a > 0 && a < 31 && b > 0 && b < 31) add({a, b, wall});
            }
        }
    }
    return cloud;
}

const Vec3 kEye(15.3, 16.1, 14.8);

/// Per stored pixel, by a grid of leaf rays in each, and their mean colours.
struct Seen {
    std::vector<double> differences;
    Cubemap mean{kFace_px};
};
Seen by_rays_everywhere(const RenderScene& scene, const Cubemap& file) {
    Seen seen;
    seen.differences.resize(6 * size_t{kFace_px} * kFace_px);
    for (size_t i = 0; i < seen.differences.size(); ++i) {
        const CubePixel owner = owner_of(pixel_at(i, kFace_px), kFace_px);
        const View view = cube_face_view(owner.face, kFace_px, kEye);
        constexpr int kSide = 96;
        Vec3 sum(0.0);
        for_each_grid_ray(scene, view, owner.x, owner.y, RayGrid(kSide), {},
                          [&](const Vec3& direction, Hit&& hit) {
                              const Rgb color = shade(scene, direction, hit);
                              const Vec3 d = Vec3(color) - Vec3(file.at(owner));
                              seen.differences[i] += glm::dot(d, d) / 3.0 / (kSide * kSide);
                              sum += Vec3(color) / double{kSide * kSide};
                          });
        seen.mean.at(pixel_at(i, kFace_px)) = Rgb(sum);
    }
    return seen;
}

void expect_found(const RenderScene& scene, const EmitterSampler* emitters) {
    const Cubemap black(kFace_px);
    CostStats cost;
    const std::vector<double> found = hidden_light({.scene = scene,
                                                    .emitters = emitters,
                                                    .origin = kEye,
                                                    .as_written = black,
                                                    .rays = 2'000'000,
                                                    .emitter_rays = 125'000,
                                                    .key = 11},
                                                   cost);
    const std::vector<double> there = by_rays_everywhere(scene, black).differences;
    ASSERT_EQ(found.size(), there.size());
    EXPECT_GT(cost.rays, 0u);
    const double most = *std::max_element(there.begin(), there.end());
    ASSERT_GT(most, 0.0);
    size_t compared = 0;
    for (size_t i = 0; i < found.size(); ++i) {
        const CubePixel pixel = pixel_at(i, kFace_px);
        const bool edge = pixel.x % (kFace_px - 1) == 0 || pixel.y % (kFace_px - 1) == 0;
        // Those at the edges of faces stand for more than their footprints.
        if (edge) continue;
        EXPECT_GE(found[i], 0.8 * there[i] - 0.02 * most) << i;
        if (there[i] < 0.5 * most) continue;  // no less than the neighbours' mean
        EXPECT_NEAR(found[i], there[i], 0.12 * there[i]) << i;
        ++compared;
    }
    EXPECT_GT(compared, 0u);
}

TEST(HiddenLight, IsFoundInTheMeasureInWhichItIsThere) {
    const VoxelTree tree = VoxelTree::build(walls_with_lamps());
    const EmitterSampler emitters(tree);
    ASSERT_GT(emitters.size(), 5u);
    expect_found({.tree = tree, .color = tree.colors().emission}, &emitters);

    auto picture = std::make_shared<Image>(64, 32);
    for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 64; ++x) {
            picture->at(x, y) = Rgb(x > 20 && x < 30 && y > 8 && y < 22 ? 50.0f : 0.1f);
        }
    }
    const Sky sky(SkyPicture{picture});
    const ColorLevels black;
    expect_found({.tree = tree, .color = black, .sky = &sky}, nullptr);
}

TEST(HiddenLight, IsNotLookedForWhereAllIsOfOneKind) {
    const VoxelTree tree = VoxelTree::build(walls_with_lamps());
    const Sky sky(Rgb(3.0f));
    const Cubemap black(kFace_px);
    const RenderScene scene{.tree = tree, .color = tree.colors().albedo, .sky = &sky};
    CostStats cost;
    EXPECT_TRUE(
        hidden_light({.scene = scene, .origin = kEye, .as_written = black, .rays = 100}, cost)
            .empty());
    EXPECT_EQ(cost.rays, 0u);
}

const IVec3 kLampAt(301, 222, 187);

/// One lamp, a twentieth of a pixel wide each way, in the dark: rays of most renders miss it.
Scene world_with_tiny_lamp(bool shown) {
    VoxelCloud cloud;
    cloud.depth = 9;
    for (int x = 0; x < 64; ++x) cloud.voxels.push_back(make_voxel({x, 0, 0}, pack_rgb(Rgb(0.5f))));
    cloud.voxels.push_back(make_voxel(kLampAt, pack_rgb(Rgb(0.5f)), pack_rgb(Rgb(60'000.0f))));
    for (int i = 0; i < 125 && !shown; ++i) {  // in a box
        const IVec3 around(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2);
        if (std::max({std::abs(around.x), std::abs(around.y), std::abs(around.z)}) < 2) continue;
        cloud.voxels.push_back(make_voxel(kLampAt + around, pack_rgb(Rgb(0.5f))));
    }
    Scene scene = test::small_scene();
    scene.tree = VoxelTree::build(cloud);
    return scene;
}

struct Baked {
    JobSpec job;
    ProbeResult result;
    double brightest = 0.0;
};

Baked bake_beside_lamp(const Scene& scene, const Json& targets, int seed) {
    const Vec3 p = scene.to_metres(Vec3(150.2, 101.7, 160.4));
    Json request = test::small_request(1, targets);
    request["seed"] = seed;
    request["face_size_px"] = kFace_px;
    request["products"] = {"cube"};
    request["quality"]["exposure"] = 1.0;
    request["lighting_states"] = Json::array({"emission"});
    request["probes"]["list"][0]["position_m"] = {p.x, p.y, p.z};
    const JobSpec job = read_job(request);
    const CancelToken cancel;
    const ReadyState state = light_state(scene, job, 0, cancel);
    const Pilot pilot = run_pilot(scene, job, make_plan(scene, job), state, cancel);
    Baked baked{job, bake_probe(scene, job, pilot, {}, cancel)};
    const Cubemap file = decode_cubemap(baked.result.files[0].bytes, "").cubemap;
    for (const Rgb& value : file.image().pixels()) {
        baked.brightest = std::max(baked.brightest, double{value.r});
    }
    return baked;
}

TEST(HiddenLight, ATinyLampIsNoProvenDarkness) {
    const Scene scene = world_with_tiny_lamp(true);
    for (int seed = 1; seed <= 8; ++seed) {
        const auto [job, result, brightest] = bake_beside_lamp(scene, {{"psnr_db", 40}}, seed);
        // The lamp's mean over its pixel, from its size: about a two-hundredth of its radiance.
        const bool right = std::abs(brightest - 180.0) < 60.0;
        EXPECT_TRUE(right || !result.target_met) << seed << ": " << brightest;
        EXPECT_GT(error_figures(job.quality, result)->rmse_interval.high, right ? 0.0 : 1.0)
            << seed;
    }
}

TEST(HiddenLight, IrradianceOfABlackFileTakesManyRaysToBelieve) {
    const Scene lit = world_with_tiny_lamp(true);
    const Scene dark = world_with_tiny_lamp(false);
    for (int seed = 1; seed <= 8; ++seed) {
        const Baked missed = bake_beside_lamp(lit, {{"irradiance_rel", 0.05}}, seed);
        EXPECT_FALSE(missed.result.target_met && missed.brightest == 0.0) << seed;
        const Baked seen = bake_beside_lamp(dark, {{"irradiance_rel", 0.05}}, seed);
        EXPECT_EQ(seen.brightest, 0.0);
        EXPECT_TRUE(seen.result.target_met) << seed;
        EXPECT_GT(seen.result.render_cost().rays + seen.result.certificate.cost.rays, 9'999U);
    }
}

}  // namespace
}  // namespace probebake
