// What a level of detail saves of a scene's shadow rays, and what it gets wrong (thesis, 3.2.2):
// rays from random points of exposed faces into the cosine-weighted hemisphere above, by every way
// of deciding on the level, against rays that go to the voxels.
#include <tbb/parallel_for.h>

#include <algorithm>

#include "light/shadow_ray.h"
#include "light/sky_light.h"
#include "math/random.h"
#include "study/experiments.h"

namespace probebake::study {
namespace {

constexpr uint64_t kRays = 400'000;
constexpr std::array<double, 2> kCones = {1.0 / 32.0, 1.0 / 8.0};
constexpr std::array<std::pair<const char*, ShadowLod>, 3> kModes = {{
    {"distance", ShadowLod::kDistance},
    {"node", ShadowLod::kNode},
    {"subtree", ShadowLod::kSubtree},
}};

struct Face {
    IVec3 voxel{0};
    CubeFace face = CubeFace::kPosX;
};

/// Exposed faces of voxels that stand in equal distances in the tree's order.
std::vector<Face> some_faces(const VoxelTree& tree) {
    std::vector<Face> faces;
    const uint64_t stride = std::max<uint64_t>(1, tree.voxel_count() / kRays);
    uint64_t at = 0;
    tree.for_each_voxel([&](const IVec3& voxel) {
        if (at++ % stride != 0) return;
        for (const CubeFace face : kCubeFaces) {
            IVec3 beside = voxel;
            beside[axis_of(face)] += index_of(face) % 2 == 0 ? 1 : -1;
            if (!tree.occupied(beside)) faces.push_back({voxel, face});
        }
    });
    return faces;
}

Ray ray_from(const Face& from, RandomStream& random) {
    const int axis = axis_of(from.face);
    Vec3 origin(from.voxel);
    if (index_of(from.face) % 2 == 0) origin[axis] += 1.0;
    origin[(axis + 1) % 3] += random.uniform();
    origin[(axis + 2) % 3] += random.uniform();
    const double u = random.uniform();
    const double v = random.uniform();
    return {origin, cosine_direction(from.face, {u, v})};
}

struct Sums {
    uint64_t rays = 0;
    uint64_t voxel_steps = 0;
    std::array<uint64_t, kCones.size() * kModes.size()> steps{};
    std::array<uint64_t, kCones.size() * kModes.size()> wrong{};
    std::array<uint64_t, kCones.size() * kModes.size()> errors_asked{};
};

}  // namespace

Json run_shadow_rays(const ExperimentInput& input) {
    const VoxelTree& tree = input.work.scene().tree;
    const std::vector<Face> faces = some_faces(tree);
    constexpr size_t kParts = 64;
    std::vector<Sums> parts(kParts);
    tbb::parallel_for(size_t{0}, kParts, [&](size_t p) {
        RandomStream random(random_key({p}));
        Sums& sums = parts[p];
        for (uint64_t i = 0; i < kRays / kParts; ++i) {
            const Ray ray = ray_from(faces[random.below(faces.size())], random);
            const double far = std::numeric_limits<double>::infinity();
            const ShadowResult exact = cast_shadow_ray(tree, ray, far);
            ++sums.rays;
            sums.voxel_steps += exact.blocker.steps;
            for (size_t c = 0; c < kCones.size(); ++c) {
                for (size_t m = 0; m < kModes.size(); ++m) {
                    const ShadowResult result = cast_shadow_ray(
                        tree, ray, far, {.lod = kModes[m].second, .cone = kCones[c]});
                    const size_t at = c * kModes.size() + m;
                    sums.steps[at] += result.blocker.steps;
                    sums.wrong[at] += result.visible != exact.visible ? 1 : 0;
                    sums.errors_asked[at] += result.errors_asked;
                }
            }
        }
    });
    Sums total;
    for (const Sums& part : parts) {
        total.rays += part.rays;
        total.voxel_steps += part.voxel_steps;
        for (size_t i = 0; i < total.steps.size(); ++i) {
            total.steps[i] += part.steps[i];
            total.wrong[i] += part.wrong[i];
            total.errors_asked[i] += part.errors_asked[i];
        }
    }
    const auto per_ray = [&](uint64_t n) {
        return static_cast<double>(n) / static_cast<double>(total.rays);
    };
    Json rows = Json::array();
    for (size_t c = 0; c < kCones.size(); ++c) {
        for (size_t m = 0; m < kModes.size(); ++m) {
            const size_t at = c * kModes.size() + m;
            rows.push_back({{"cone", kCones[c]},
                            {"mode", kModes[m].first},
                            {"steps_per_ray", per_ray(total.steps[at])},
                            {"wrong", per_ray(total.wrong[at])},
                            {"errors_per_ray", per_ray(total.errors_asked[at])}});
        }
    }
    return {{"rays", total.rays},
            {"voxel_steps_per_ray", per_ray(total.voxel_steps)},
            {"rows", std::move(rows)}};
}

}  // namespace probebake::study
