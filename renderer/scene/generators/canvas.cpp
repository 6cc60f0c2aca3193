#include "scene/generators/canvas.h"

#include <algorithm>
#include <cmath>

#include "scene/generators/noise.h"
#include "scene/generators/palette.h"

namespace probebake::worldgen {

Rgb natural_albedo(const Rgb& color) { return glm::clamp(color, Rgb(0.015f), Rgb(0.9f)); }

double Canvas::hash(const IVec3& voxel) const {
    const uint64_t code = (static_cast<uint64_t>(voxel.x) << 40) ^
                          (static_cast<uint64_t>(voxel.y) << 20) ^ static_cast<uint64_t>(voxel.z);
    return static_cast<double>(mix64(key_ + code * 0x9E3779B97F4A7C15ull) >> 11) * 0x1.0p-53;
}

bool Canvas::hidden(const IVec3& v) const {
    if (v.x < 0 || v.y < 0 || v.z < 0 || v.x >= size_ || v.y >= size_ || v.z >= size_) return true;
    return ground_ != nullptr && v.y < ground_->top(v.x, v.z);
}

void Canvas::put(const IVec3& voxel, const Paint& paint) {
    if (hidden(voxel)) return;
    const double brightness = 1.0 + paint.grain * (2.0 * hash(voxel) - 1.0);
    const Rgb albedo = natural_albedo(paint.color * static_cast<float>(brightness));
    voxels_.push_back(make_voxel(voxel, pack_rgb(albedo), pack_rgb(paint.emission),
                                 static_cast<uint16_t>(paint.layer)));
}

void Canvas::put_ground(const IVec3& voxel, const Rgb& albedo) {
    voxels_.push_back(make_voxel(voxel, pack_rgb(natural_albedo(albedo)), 0,
                                 static_cast<uint16_t>(Layer::kGround)));
}

void Canvas::limb(const Vec3& from_m, const Vec3& to_m, const Vec2& radii_m, const Paint& paint) {
    const Vec3 along = to_m - from_m;
    const double length = std::sqrt(glm::dot(along, along));
    const int steps = std::max(1, static_cast<int>(std::ceil(length / (0.7 * voxel_m_))));
    IVec3 last(-1);
    for (int i = 0; i <= steps; ++i) {
        const double t = static_cast<double>(i) / steps;
        const Vec3 center = from_m + along * t;
        const double radius = mix(radii_m.x, radii_m.y, t);
        const IVec3 middle = voxel_at(center);
        if (radius < 0.75 * voxel_m_) {
            if (middle != last) put(middle, paint);
        } else {
            const int reach = static_cast<int>(std::ceil(radius / voxel_m_));
            for (int z = -reach; z <= reach; ++z) {
                for (int x = -reach; x <= reach; ++x) {
                    const IVec3 v = middle + IVec3(x, 0, z);
                    const Vec3 d = center_m(v) - center;
                    const double r2 = d.x * d.x + d.z * d.z;
                    const double inner = std::max(0.0, radius - 1.5 * voxel_m_);
                    if (r2 <= radius * radius && r2 >= inner * inner) put(v, paint);
                }
            }
        }
        last = middle;
    }
}

void Canvas::box(const Vec3& lo_m, const Vec3& hi_m, const Paint& paint) {
    const IVec3 lo = IVec3(glm::floor(lo_m / voxel_m_ + 0.5));
    const IVec3 hi = glm::max(IVec3(glm::floor(hi_m / voxel_m_ + 0.5)), lo + 1);
    for (int z = lo.z; z < hi.z; ++z) {
        for (int y = lo.y; y < hi.y; ++y) {
            for (int x = lo.x; x < hi.x; ++x) put({x, y, z}, paint);
        }
    }
}

void Canvas::foliage(const Vec3& center, const Vec3& radii_m, const Foliage& foliage,
                     uint64_t key) {
    // An ellipsoid thinner than a voxel is widened to one and thinned out to cover as much ground.
    const Vec3 radii = glm::max(radii_m, Vec3(0.5 * voxel_m_));
    const double thinning = radii_m.x * radii_m.z / (radii.x * radii.z);
    const double share = std::min(0.9, foliage.density_per_m * voxel_m_ * thinning);
    // Where many thin clouds meet in one voxel, each has its part in the snow.
    const double snow_share = foliage.snow * thinning;
    const IVec3 lo = voxel_at(center - radii);
    const IVec3 hi = voxel_at(center + radii);
    RandomStream random(key);
    for (int z = lo.z; z <= hi.z; ++z) {
        for (int y = lo.y; y <= hi.y; ++y) {
            for (int x = lo.x; x <= hi.x; ++x) {
                const IVec3 v(x, y, z);
                const Vec3 d = (center_m(v) - center) / radii;
                if (glm::dot(d, d) > 1.0) continue;
                if (random.uniform() >= share) continue;
                const bool snowy =
                    foliage.snow > 0.0 && random.uniform() < snow_share * (0.55 + d.y);
                // Inner and lower leaves are older and darker.
                const Rgb leaf = foliage.color * static_cast<float>(1.0 + 0.25 * d.y);
                put(v, {snowy ? palette::kSnow : leaf, snowy ? 0.05 : 0.25, foliage.layer});
            }
        }
    }
}

}  // namespace probebake::worldgen
