// The beam of the Cornell box (thesis, 3.2.2, figures 3.4-3.6): light that falls through a grating
// of one-voxel bars onto a floor, found by shadow rays at a level of detail.
//
// From every voxel of the floor shadow rays go to stratified points of the light: irradiance ∝
// cos · cos / distance². Level 1, 2, 3 from 64, 128, 256 voxels away: the grating is closed from
// level 1 on. What each way of deciding on the level leaves of the light is compared with leaf
// rays, over the floor and along z.
#include <tbb/parallel_for.h>

#include <cmath>

#include "light/shadow_ray.h"
#include "math/random.h"
#include "scene/generators/cornell.h"
#include "study/experiments.h"

namespace probebake::study {
namespace {

constexpr double kBeamCone = 2.0 / 64.0;  // level 1, edge 2, from 64 voxels on
constexpr int kLightGrid = 4;             // rays per floor voxel: its square
constexpr int kStrip = 10;                // voxels of z in a row of the profile

struct Mode {
    const char* name;
    ShadowSettings settings;
};
constexpr std::array<Mode, 5> kModes = {{
    {"leaf", {}},
    {"distance", {.lod = ShadowLod::kDistance, .cone = kBeamCone}},
    {"node", {.lod = ShadowLod::kNode, .cone = kBeamCone}},
    {"node_decay_1", {.lod = ShadowLod::kNode, .cone = kBeamCone, .decay = 1.0}},
    {"subtree", {.lod = ShadowLod::kSubtree, .cone = kBeamCone}},
}};

struct FloorRow {
    std::array<double, kModes.size()> light{};
    std::array<uint64_t, kModes.size()> steps{};
    std::array<uint64_t, kModes.size()> errors_asked{};
};

/// All rays of the floor's voxels with this z.
FloorRow light_row(const VoxelTree& tree, int z) {
    FloorRow row;
    for (int x = cornell::kFloorRegionMin.x; x < cornell::kFloorRegionMax.x; ++x) {
        RandomStream random(random_key({static_cast<uint64_t>(x), static_cast<uint64_t>(z)}));
        for (int i = 0; i < kLightGrid * kLightGrid; ++i) {
            const Vec2 on_floor(random.uniform(), random.uniform());
            const Vec2 on_light =
                (Vec2(i % kLightGrid, i / kLightGrid) + Vec2(random.uniform(), random.uniform())) /
                double{kLightGrid};
            const Vec3 from(x + on_floor.x, cornell::kFloorY + 1.0, z + on_floor.y);
            const Vec3 extent(cornell::kLightMax - cornell::kLightMin);
            const Vec3 to(cornell::kLightMin.x + on_light.x * extent.x,
                          cornell::kLightMin.y + on_light.y * extent.y, cornell::kLightMax.z);
            const double distance = glm::distance(from, to);
            const Ray ray{from, (to - from) / distance};
            const double light =
                ray.direction.y * -ray.direction.z / (distance * distance);  // cos · cos / d²
            for (size_t m = 0; m < kModes.size(); ++m) {
                const ShadowResult result =
                    cast_shadow_ray(tree, ray, distance, kModes[m].settings);
                row.light[m] += result.visible ? light : 0.0;
                row.steps[m] += result.blocker.steps;
                row.errors_asked[m] += result.errors_asked;
            }
        }
    }
    return row;
}

}  // namespace

Json run_beam(const ExperimentInput& input) {
    const VoxelTree& tree = input.work.scene().tree;
    const int first = cornell::kFloorRegionMin.z;
    const int count = cornell::kFloorRegionMax.z - first;
    std::vector<FloorRow> rows(static_cast<size_t>(count));
    tbb::parallel_for(0, count,
                      [&](int i) { rows[static_cast<size_t>(i)] = light_row(tree, first + i); });
    Json profile = Json::array();
    FloorRow total;
    for (int i = 0; i < count; i += kStrip) {
        FloorRow strip;
        for (int j = i; j < std::min(count, i + kStrip); ++j) {
            const FloorRow& row = rows[static_cast<size_t>(j)];
            for (size_t m = 0; m < kModes.size(); ++m) {
                strip.light[m] += row.light[m];
                total.steps[m] += row.steps[m];
                total.errors_asked[m] += row.errors_asked[m];
            }
        }
        Json line = {{"z", first + i}};
        for (size_t m = 0; m < kModes.size(); ++m) {
            line[kModes[m].name] = strip.light[m];
            total.light[m] += strip.light[m];
        }
        profile.push_back(std::move(line));
    }
    const auto rays = static_cast<double>(
        int64_t{count} * (cornell::kFloorRegionMax.x - cornell::kFloorRegionMin.x) * kLightGrid *
        kLightGrid);
    Json modes = Json::array();
    for (size_t m = 0; m < kModes.size(); ++m) {
        // The last strip that still has a hundredth of the light it should have.
        int lit_until = first;
        for (const Json& line : profile) {
            const double light = line[kModes[m].name].get<double>();
            if (light > 0.01 * line["leaf"].get<double>()) {
                lit_until = line["z"].get<int>() + kStrip;
            }
        }
        modes.push_back({{"mode", kModes[m].name},
                         {"kept", total.light[m] / total.light[0]},
                         {"lit_until_z", lit_until},
                         {"steps_per_ray", static_cast<double>(total.steps[m]) / rays},
                         {"errors_per_ray", static_cast<double>(total.errors_asked[m]) / rays}});
    }
    return {{"modes", std::move(modes)}, {"profile", std::move(profile)}};
}

}  // namespace probebake::study
