// Nodes that stand on both sides of a wall (light/face_colors.h, "divided"): how many there are,
// how often a ray is shown something finer because of them, and what that does to the picture.
//
// A low sun and a dim sky on the scene; probes of 64² and of 16² pixels a face, for the fewer the
// pixels, the coarser the nodes. "Before" shows every node's own mean.
#include <cmath>
#include <numbers>

#include "light/lighting.h"
#include "render/render.h"
#include "study/experiments.h"

namespace probebake::study {
namespace {

constexpr std::array<int, 2> kFaces_px = {64, 16};
constexpr int kTruthGrid = 8;
constexpr size_t kProbes = 2;

Lighting low_sun() {
    return {
        .sun = Sun{.direction = {0.75, 0.5, 0.43}, .irradiance = Rgb(std::numbers::pi_v<float>)},
        .sky = Sky(Rgb(0.1f)),
        .emission = false};
}

Json divided_by_level(const VoxelTree& tree, const FaceColors& colors) {
    Json rows = Json::array();
    const auto add = [&](int level, std::span<const uint8_t> divided,
                         std::span<const uint8_t> exposed) {
        uint64_t count = 0;
        uint64_t values = 0;
        for (const uint8_t one : exposed) values += static_cast<uint64_t>(std::popcount(one));
        for (const uint8_t one : divided) count += static_cast<uint64_t>(std::popcount(one));
        rows.push_back({{"level", level}, {"values", values}, {"divided", count}});
    };
    for (int k = 0; k < tree.node_levels(); ++k) {
        const std::span<const VoxelNode> level = tree.node_level(k);
        const std::span octants(colors.octants.divided);
        const std::span nodes(colors.nodes.divided);
        const uint32_t first = level.front().octant_base;
        const VoxelNode& last = level.back();
        const auto end =
            last.octant_base + static_cast<uint32_t>(std::popcount(nonzero_bytes(last.mask)));
        add(2 * k + 1, octants.subspan(first, end - first),
            std::span(colors.octants.exposed).subspan(first, end - first));
        if (2 * k + 2 > tree.depth()) break;  // an odd depth ends at an octant
        add(2 * k + 2, nodes.subspan(tree.level_begin(k), level.size()),
            std::span(colors.nodes.exposed).subspan(tree.level_begin(k), level.size()));
    }
    return rows;
}

/// Share of the probe's LOD rays that meet a divided node.
double share_divided(const RenderScene& scene, const Vec3& origin, int n) {
    uint64_t hits = 0;
    uint64_t divided = 0;
    for (const CubeFace face : kCubeFaces) {
        const View view = cube_face_view(face, n, origin);
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                const PixelRay cast = pixel_ray(view, x, y);
                const Hit hit = trace(scene.tree, cast.ray, {.cone = cast.cone});
                if (!hit) continue;
                ++hits;
                divided += scene.lit->divided(scene.tree, hit, hit.level) ? 1 : 0;
            }
        }
    }
    return hits > 0 ? static_cast<double>(divided) / static_cast<double>(hits) : 0.0;
}

Image picture(const RenderScene& scene, const Vec3& origin, int n, const RenderSettings& settings) {
    const CancelToken cancel;
    return render_cubemap(scene, origin, n, settings, cancel).color.image();
}

double squared_error(const Image& a, const Image& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.pixels().size(); ++i) {
        const Vec3 difference = Vec3(a.pixels()[i]) - Vec3(b.pixels()[i]);
        sum += glm::dot(difference, difference);
    }
    return sum / (3.0 * static_cast<double>(a.pixels().size()));
}

}  // namespace

Json run_walls(const ExperimentInput& input) {
    const Scene& scene = input.work.scene();
    const CancelToken cancel;
    const LitScene lit = light_scene(scene.tree, low_sun(),
                                     {.sun_rays = 1, .sky_rays = 8, .gather_level = 2}, cancel);
    FaceColors before = lit.colors;
    for (FaceLevel* level : {&before.octants, &before.nodes}) {
        level->divided.assign(level->divided.size(), 0);
    }
    const Sky sky = low_sun().sky;
    const auto scene_with = [&](const FaceColors& colors) {
        return RenderScene{
            .tree = scene.tree, .color = scene.tree.colors().albedo, .lit = &colors, .sky = &sky};
    };
    const RenderScene now = scene_with(lit.colors);
    const RenderScene then = scene_with(before);
    const std::vector<Vec3>& positions = input.work.probe_positions_m();
    const size_t probes = std::min(kProbes, positions.size());
    Json rows = Json::array();
    for (const int n : kFaces_px) {
        double share = 0.0;
        std::array<double, 2> lod{};
        std::array<double, 2> hybrid{};
        for (size_t p = 0; p < probes; ++p) {
            const Vec3 origin = scene.to_voxels(positions[p]);
            const Image truth = picture(
                now, origin, n, {.kind = RendererKind::kReference, .leaf_grid = kTruthGrid});
            const RenderSettings by_lod{.kind = RendererKind::kLod};
            const RenderSettings by_hybrid{.kind = RendererKind::kHybrid, .leaf_grid = 1};
            share += share_divided(now, origin, n) / static_cast<double>(probes);
            lod[0] += squared_error(picture(then, origin, n, by_lod), truth);
            lod[1] += squared_error(picture(now, origin, n, by_lod), truth);
            hybrid[0] += squared_error(picture(then, origin, n, by_hybrid), truth);
            hybrid[1] += squared_error(picture(now, origin, n, by_hybrid), truth);
        }
        const auto rmse = [&](double sum) { return std::sqrt(sum / static_cast<double>(probes)); };
        rows.push_back({{"face_px", n},
                        {"shown_finer", share},
                        {"lod_rmse", rmse(lod[1])},
                        {"lod_rmse_before", rmse(lod[0])},
                        {"hybrid_rmse", rmse(hybrid[1])},
                        {"hybrid_rmse_before", rmse(hybrid[0])}});
    }
    return {{"levels", divided_by_level(scene.tree, lit.colors)}, {"rows", std::move(rows)}};
}

}  // namespace probebake::study
