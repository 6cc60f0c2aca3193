// Embree as a yardstick: closest hits on the same triangles, compared ray by ray before anything is
// timed. Prints the rows of docs/results/meshes.md.
#include <embree3/rtcore.h>
#include <gtest/gtest.h>

#include <ctime>
#include <iomanip>
#include <iostream>
#include <memory>

#include "mesh/mesh_rays.h"
#include "mesh/mesh_worlds.h"
#include "mesh/real_meshes.h"

namespace probebake {
namespace {

constexpr int kResolution = 1024;
constexpr size_t kRays = 200'000;
constexpr int kRounds = 3;  // the fastest counts

double cpu_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Work>
double least_seconds(const Work& work) {
    double least = kInfinity;
    for (int i = 0; i < kRounds; ++i) {
        const double begin = cpu_seconds();
        work();
        least = std::min(least, cpu_seconds() - begin);
    }
    return least;
}

struct Hit1 {
    float t = std::numeric_limits<float>::infinity();
    uint32_t triangle = ObjectHit::kNone;
};

class EmbreeScene {
  public:
    explicit EmbreeScene(const GridMesh& grid)
        : device_(::rtcNewDevice("threads=1,set_affinity=0"), &::rtcReleaseDevice),
          scene_(::rtcNewScene(device_.get()), &::rtcReleaseScene) {
        ::rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = ::rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        const size_t count = grid.triangles.size();
        auto* const points = static_cast<float*>(::rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * count));
        auto* const indices = static_cast<uint32_t*>(::rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
        for (size_t i = 0; i < count; ++i) {
            const std::array<Vec3, 3> corners = corners_of(grid.triangles[i]);
            for (size_t k = 0; k < 3; ++k) {
                indices[3 * i + k] = static_cast<uint32_t>(3 * i + k);
                for (int axis = 0; axis < 3; ++axis) {
                    points[9 * i + 3 * k + static_cast<size_t>(axis)] =
                        static_cast<float>(corners[k][axis]);
                }
            }
        }
        ::rtcCommitGeometry(geometry);
        ::rtcAttachGeometry(scene_.get(), geometry);
        ::rtcReleaseGeometry(geometry);
        ::rtcCommitScene(scene_.get());
    }

    Hit1 closest_hit(const Ray& ray) const {
        RTCIntersectContext context;
        ::rtcInitIntersectContext(&context);
        RTCRayHit query{};
        query.ray.org_x = static_cast<float>(ray.origin.x);
        query.ray.org_y = static_cast<float>(ray.origin.y);
        query.ray.org_z = static_cast<float>(ray.origin.z);
        query.ray.dir_x = static_cast<float>(ray.direction.x);
        query.ray.dir_y = static_cast<float>(ray.direction.y);
        query.ray.dir_z = static_cast<float>(ray.direction.z);
        query.ray.tfar = std::numeric_limits<float>::infinity();
        query.ray.mask = ~0u;
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        ::rtcIntersect1(scene_.get(), &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
        return {query.ray.tfar, query.hit.primID};
    }

  private:
    std::unique_ptr<RTCDeviceTy, decltype(&::rtcReleaseDevice)> device_;
    std::unique_ptr<RTCSceneTy, decltype(&::rtcReleaseScene)> scene_;
};

/// Rays from anywhere in the mesh's box to anywhere, their numbers those of float: both see the
/// same ones.
std::vector<Ray> random_rays(const Vec3& extent) {
    std::vector<Ray> rays(kRays);
    const auto rounded = [](const Vec3& v) { return Vec3(glm::vec3(v)); };
    for (size_t i = 0; i < kRays; ++i) {
        RandomStream random(random_key({0x656D62726565, i}));
        const double z = 2.0 * random.uniform() - 1.0;
        const double angle = 6.283185307179586 * random.uniform();
        const double r = std::sqrt(1.0 - z * z);
        rays[i].origin =
            rounded(Vec3(random.uniform(), random.uniform(), random.uniform()) * extent);
        rays[i].direction = rounded({r * std::cos(angle), r * std::sin(angle), z});
    }
    return rays;
}

/// The pixels of a face from the middle of the mesh: neighbours go the same way.
std::vector<Ray> camera_rays(const Vec3& extent) {
    constexpr int kSide = 447;
    std::vector<Ray> rays;
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            const Vec3 direction(2.0 * x / (kSide - 1) - 1.0, 2.0 * y / (kSide - 1) - 1.0, 1.0);
            rays.push_back({0.5 * extent, Vec3(glm::vec3(glm::normalize(direction)))});
        }
    }
    return rays;
}

void compare_and_time(const std::string& name, const TriangleMesh& mesh, double voxel_size_m) {
    const GridMesh grid = make_grid_mesh(mesh, voxel_size_m);
    const double build_embree = least_seconds([&] { EmbreeScene scene(grid); });
    const double build_ours = least_seconds([&] { test::MeshRays rays(grid); });
    const EmbreeScene embree(grid);
    const test::MeshRays ours(grid);
    std::cout << name << ": " << grid.triangles.size() << " triangles, build " << std::fixed
              << std::setprecision(3) << build_ours << " s (Embree " << build_embree << " s)\n";
    for (const bool coherent : {false, true}) {
        const std::vector<Ray> rays =
            coherent ? camera_rays(Vec3(grid.extent)) : random_rays(Vec3(grid.extent));
        uint64_t hits = 0;
        uint64_t apart = 0;
        for (const Ray& ray : rays) {
            const ObjectHit a = ours.closest_hit(ray);
            const Hit1 b = embree.closest_hit(ray);
            const bool found = b.triangle != ObjectHit::kNone;
            hits += a ? 1 : 0;
            // Positions of a thousand voxels have a float's step of 6e-5.
            if (static_cast<bool>(a) != found ||
                (a && !(std::abs(a.t - static_cast<double>(b.t)) <= 2e-3))) {
                ++apart;
            }
        }
        // Rays that graze an edge are decided by rounding, float against double.
        EXPECT_LE(static_cast<double>(apart), 5e-4 * static_cast<double>(rays.size())) << name;
        EXPECT_GT(hits, rays.size() / 100);
        const auto row = [&](const char* what, double seconds) {
            std::cout << "  " << (coherent ? "camera" : "random") << ' ' << what << ' '
                      << std::setprecision(0) << 1e9 * seconds / static_cast<double>(rays.size())
                      << " ns\n";
        };
        std::cout << "  " << rays.size() << " rays, " << hits << " hits, " << apart << " apart\n";
        double sum = 0.0;
        row("Embree", least_seconds([&] {
                for (const Ray& ray : rays) sum += static_cast<double>(embree.closest_hit(ray).t);
            }));
        const auto by = [&](OctreeTraversal how) {
            return least_seconds([&] {
                CastCounts counts;
                for (const Ray& ray : rays) sum += ours.closest_hit(ray, {}, how, counts).t;
            });
        };
        row("octree, Glassner", by(OctreeTraversal::kFromRoot));
        row("octree, Samet", by(OctreeTraversal::kFromAncestor));
        row("octree, Gargantini", by(OctreeTraversal::kTopDown));
        if (sum == 0.5) std::cout << '\n';  // the sum is of use
    }
}

TEST(Embree, FindsTheSameHitsOnAGeneratedLevel) {
    compare_and_time("level", test::make_level(180, 300, 1000.0, 1), 1.0);
}

TEST(Embree, FindsTheSameHitsOnRealMeshes) {
    int found = 0;
    for (const test::RealMesh& mesh : test::kRealMeshes) {
        const auto file = test::mesh_file_of(mesh, kResolution);
        if (!file) continue;
        ++found;
        const TriangleMesh triangles = load_mesh(*file);
        compare_and_time(mesh.name, triangles, mesh_voxel_size_m(*file, triangles));
    }
    if (found == 0) GTEST_SKIP() << "no meshes in PROBEBAKE_DATA";
}

}  // namespace
}  // namespace probebake
