#include "volume_study/clouds.h"

#include <algorithm>

#include "scene/generators/cumulus.h"
#include "scene/vdb/vdb_file.h"
#include "volume/phase.h"

namespace probebake::volume_study {
namespace {

constexpr double kEdge = 1000.0;  // m

Cloud place(std::string name, DensityGrid grid) {
    Cloud cloud;
    cloud.name = std::move(name);
    const IVec3 cells = grid.cells();
    const double per_cell = kEdge / std::max({cells.x, cells.y, cells.z});
    cloud.shape.index_to_world.linear = glm::dmat3(per_cell);
    cloud.shape.index_to_world.offset = -per_cell * Vec3(grid.low());
    constexpr int kRays = 64;
    for (int z = 0; z < kRays; ++z) {
        for (int x = 0; x < kRays; ++x) {
            const Vec3 at =
                Vec3(grid.low()) + Vec3(cells) * Vec3((x + 0.5) / kRays, 0.0, (z + 0.5) / kRays);
            cloud.thickest =
                std::max(cloud.thickest, per_cell * grid_column(grid, {at, {0, 1, 0}}, {}));
        }
    }
    cloud.shape.density = std::make_shared<DensityGrid>(std::move(grid));
    return cloud;
}

}  // namespace

std::vector<Cloud> load_clouds(const VolumeStudyParams& params) {
    std::vector<Cloud> clouds;
    if (params.cloud) {
        clouds.push_back(
            place(params.cloud->stem().string(), read_vdb_grid(*params.cloud, "density").grid));
    }
    if (params.cumulus_size > 0) {
        clouds.push_back(place("cumulus_" + std::to_string(params.cumulus_size),
                               make_cumulus({.size = params.cumulus_size})));
    }
    return clouds;
}

MediumSpec cloud_medium(const Cloud& cloud, double column, const Rgb& absorb, const Rgb& scatter,
                        double g) {
    const Rgb sum = absorb + scatter;
    const auto per_m =
        static_cast<float>(column / cloud.thickest / double{std::max({sum.r, sum.g, sum.b})});
    MediumSpec spec;
    spec.name = cloud.name;
    spec.absorption_per_m = absorb * per_m;
    spec.scattering_per_m = scatter * per_m;
    spec.g = g;
    spec.shape = cloud.shape;
    return spec;
}

Ray ray_at_cloud(const Cloud& cloud, RandomStream& random) {
    const Vec3 size(cloud.shape.density->cells());
    const double u = random.uniform();
    const double v = random.uniform();
    const double w = random.uniform();
    const Vec3 target = cloud.shape.index_to_world.point(Vec3(cloud.shape.density->low()) +
                                                         size * (Vec3(0.25) + 0.5 * Vec3(u, v, w)));
    const double cosine = 2.0 * random.uniform() - 1.0;
    const Vec3 direction = around({0, 1, 0}, cosine, random.uniform());
    return {target - direction * (2.0 * kEdge), direction};
}

}  // namespace probebake::volume_study
