#include "volume_study/probes.h"

#include <cmath>

#include "image/exr.h"
#include "image/preview.h"
#include "io/file.h"
#include "scatter/volume_cubemap.h"
#include "scene/generators/generators.h"

namespace probebake::volume_study {
namespace {

using study::decimals;

constexpr int kFaceSize = 64;
constexpr double kTargetRmse = 0.1;
constexpr double kCloudEdge = 320.0;      // m, of the cloud's longest side
constexpr double kCloudBase = 190.0;      // m above the world's lowest corner
constexpr double kColumn = 40.0;          // optical thicknesses
constexpr uint64_t kMostPaths = 500'000;  // of a render

double rmse(const Cubemap& a, const Cubemap& b) {
    const auto pa = a.image().pixels();
    const auto pb = b.image().pixels();
    double sum = 0.0;
    for (size_t i = 0; i < pa.size(); ++i) {
        const Vec3 d = Vec3(pa[i]) - Vec3(pb[i]);
        sum += glm::dot(d, d) / 3.0;
    }
    return std::sqrt(sum / static_cast<double>(pa.size()));
}

/// The cloud's longest side scaled, its middle above the middle of the world.
MediumSpec placed_cloud(const Cloud& cloud, double world_m) {
    Cloud placed = cloud;
    const DensityGrid& grid = *cloud.shape.density;
    const IVec3& cells = grid.cells();
    const double per_cell = kCloudEdge / std::max({cells.x, cells.y, cells.z});
    Affine& map = placed.shape.index_to_world;
    placed.thickest = cloud.thickest * per_cell / map.linear[0][0];
    map.linear = glm::dmat3(per_cell);
    const Vec3 size = per_cell * Vec3(cells);
    map.offset = Vec3(0.5 * (world_m - size.x), kCloudBase, 0.5 * (world_m - size.z)) -
                 per_cell * Vec3(grid.low());
    return cloud_medium(placed, kColumn, Rgb(0.0f), Rgb(1.0f), 0.8);
}

}  // namespace

study::TextTable probe_table(const Cloud& cloud, const std::filesystem::path& out,
                             const std::function<void(const std::string&)>& progress) {
    study::TextTable table;
    table.name = "probes";
    table.title = "Eight probes of 64² around " + cloud.name + " over a mountain, target RMSE " +
                  decimals(kTargetRmse, 2);
    table.columns = {"probe",          "paths per pixel", "lookups, M",
                     "scatterings, M", "predicted RMSE",  "measured RMSE",
                     "rounds",         "target met",      "faults"};
    const GeneratorParams world{.name = "mountain", .size = 256, .seed = 1};
    const double voxel_m = voxel_size_m(world);
    const double world_m = voxel_m * world.size;
    const VoxelTree tree = VoxelTree::build(generate(world));
    const Media media({placed_cloud(cloud, world_m)}, {.max_depth = 8, .threshold = 0.5});
    Lighting lighting;
    lighting.sun = Sun{.direction = {0.5, 0.7, 0.4},
                       .irradiance = Rgb(20.0f, 18.0f, 15.0f),
                       .angular_diameter_deg = 0.53};
    lighting.sky = Sky(SkyGradient{Rgb(0.25f, 0.5f, 1.2f), Rgb(0.9f, 1.0f, 1.2f), Rgb(0.1f)});
    const TrackerChoice choice = choose_tracker(facts_of(media));
    const PathTracer tracer({tree, voxel_m, Vec3(0.0), media, lighting}, choice);
    const double middle = 0.5 * world_m;
    const std::vector<Vec3> probes = {{middle - 60.0, kCloudBase - 20.0, middle - 250.0},
                                      {middle, kCloudBase - 15.0, middle},
                                      {middle, kCloudBase + 60.0, middle},
                                      {middle, kCloudBase + 250.0, middle},
                                      {20.0, kCloudBase + 60.0, 20.0},
                                      {world_m, kCloudBase + 80.0, middle},
                                      {middle + 50.0, kCloudBase + 40.0, middle + 60.0},
                                      {middle, 20.0 + kCloudBase, world_m}};
    const CancelToken cancel;
    for (size_t i = 0; i < probes.size(); ++i) {
        progress("probes: " + std::to_string(i));
        VolumeView view{.origin_m = probes[i], .face_size_px = kFaceSize, .range = {0.0, 1e5}};
        const VolumeQuality quality{.target_rmse = kTargetRmse, .most_paths = kMostPaths};
        view.key = random_key({i, 1});
        const VolumeCubemap cube = render_volume_cubemap(tracer, view, quality, cancel);
        view.key = random_key({i, 2});
        const VolumeCubemap again = render_volume_cubemap(tracer, view, quality, cancel);
        const auto millions = [](uint64_t x) { return decimals(static_cast<double>(x) * 1e-6, 2); };
        table.rows.push_back({std::to_string(i),
                              decimals(static_cast<double>(cube.count().paths) /
                                           static_cast<double>(owned_pixel_count(kFaceSize)),
                                       1),
                              millions(cube.count().lookups()), millions(cube.count().scatterings),
                              decimals(cube.predicted_rmse, 4),
                              decimals(rmse(cube.color, again.color) / std::sqrt(2.0), 4),
                              std::to_string(cube.rounds), cube.target_met ? "yes" : "no",
                              std::to_string(cube.count().all_faults())});
        if (i == 0) {
            ProbeAttributes attributes;
            attributes.id = "p0";
            attributes.position_m = probes[i];
            write_file_atomically(out / "probe.exr", encode_cubemap(cube.color, attributes).bytes);
            write_file_atomically(
                out / "probe.png",
                encode_panorama_png(cube.color, 384, {.exposure = 4.0, .shoulder = true}));
        }
    }
    return table;
}

}  // namespace probebake::volume_study
