#include "study/octrees/spd_rays.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace probebake::study {
namespace {

/// Hits nearer to a secondary ray's origin, in diagonals of the scene, are the surface it left.
constexpr double kSurfaceOffset = 1e-7;

class Tracer {
  public:
    Tracer(const NffScene& scene, const ObjectOctree& octree, int max_depth,
           std::vector<SpdRay>& rays)
        : scene_(scene), octree_(octree), max_depth_(max_depth), rays_(rays) {
        const Box& box = octree.octree().tree().box();
        offset_ = kSurfaceOffset * glm::length(box.high - box.low);
    }

    void trace(const Ray& ray, int depth) {
        SpdRay cast{.ray = ray,
                    .range = {depth == 1 ? 0.0 : offset_, kInfinity},
                    .kind = depth == 1 ? SpdRayKind::kEye : SpdRayKind::kSecondary};
        cast.hit = octree_.closest_hit(ray, cast.range);
        rays_.push_back(cast);
        if (!cast.hit) return;
        const Vec3 point = ray.origin + cast.hit.t * ray.direction;
        const Vec3 normal = normal_at(scene_.shapes, cast.hit.object, point);
        for (const NffLight& light : scene_.lights) to_light(point, normal, light);
        if (depth >= max_depth_) return;
        const NffMaterial& material = scene_.materials[scene_.objects[cast.hit.object].material];
        const bool transmits = material.transmittance > 0.0;
        if (material.specular > 0.0 || transmits) {
            trace({point, glm::normalize(glm::reflect(ray.direction, normal))}, depth + 1);
        }
        if (transmits) {
            if (const auto through = refracted(ray.direction, normal, material.refraction_index)) {
                trace({point, *through}, depth + 1);
            }
        }
    }

  private:
    static std::optional<Vec3> refracted(const Vec3& direction, const Vec3& normal, double index) {
        const double along = glm::dot(direction, normal);
        const double ratio = along < 0.0 ? 1.0 / index : index;
        const Vec3 facing = along < 0.0 ? normal : -normal;
        const double cosine = std::abs(along);
        const double square = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
        if (!(square > 0.0)) return std::nullopt;
        return glm::normalize(ratio * direction + (ratio * cosine - std::sqrt(square)) * facing);
    }

    void to_light(const Vec3& point, const Vec3& normal, const NffLight& light) {
        const Vec3 to = light.position - point;
        const double distance = glm::length(to);
        if (!(glm::dot(to, normal) > 0.0)) return;
        SpdRay cast{.ray = {point, to / distance},
                    .range = {offset_, distance},
                    .kind = SpdRayKind::kShadow};
        CastCounts counts;
        cast.hit = octree_.any_hit(cast.ray, cast.range, OctreeTraversal::kTopDown, counts);
        rays_.push_back(cast);
    }

    const NffScene& scene_;
    const ObjectOctree& octree_;
    int max_depth_;
    std::vector<SpdRay>& rays_;
    double offset_ = 0.0;
};

}  // namespace

std::vector<SpdRay> spd_rays(const NffScene& scene, const ObjectOctree& octree,
                             const SpdRayParams& params) {
    if (!scene.view) throw std::invalid_argument("the scene has no view to cast rays from");
    const NffView& view = *scene.view;
    const Vec3 forward = glm::normalize(view.at - view.from);
    const Vec3 right = glm::normalize(glm::cross(forward, view.up));
    const Vec3 up = glm::cross(right, forward);
    const double half = std::tan(view.angle_deg * std::numbers::pi / 360.0);

    const auto rows = static_cast<size_t>(params.size_px) + 1;
    std::vector<std::vector<SpdRay>> of_row(rows);
    tbb::parallel_for(size_t{0}, rows, [&](size_t y) {
        Tracer tracer(scene, octree, params.max_depth, of_row[y]);
        for (int x = 0; x <= params.size_px; ++x) {
            const double u = half * (2.0 * x / params.size_px - 1.0);
            const double v = half * (1.0 - 2.0 * static_cast<double>(y) / params.size_px);
            tracer.trace({view.from, glm::normalize(forward + u * right + v * up)}, 1);
        }
    });
    std::vector<SpdRay> rays;
    for (std::vector<SpdRay>& row : of_row) {
        rays.insert(rays.end(), row.begin(), row.end());
        row = {};
    }
    return rays;
}

SpdRayCounts count_rays(const std::vector<SpdRay>& rays) {
    SpdRayCounts counts;
    for (const SpdRay& ray : rays) {
        const auto kind = static_cast<size_t>(ray.kind);
        ++counts.cast[kind];
        if (ray.hit) ++counts.used[kind];
    }
    return counts;
}

}  // namespace probebake::study
