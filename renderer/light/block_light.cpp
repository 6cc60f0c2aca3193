#include "light/block_light.h"

#include <algorithm>
#include <numbers>
#include <numeric>

#include "math/sampling.h"

namespace probebake {
namespace {

/// What the stage's random streams are for.
enum class Purpose : uint64_t { kSun = 0x73756E, kSky = 0x736B79 };

Vec3 normal_of(int face) {
    Vec3 normal(0.0);
    normal[face / 2] = face % 2 == 0 ? 1.0 : -1.0;
    return normal;
}

/// Two unit vectors across a direction.
std::array<Vec3, 2> across(const Vec3& direction) {
    const Vec3 helper = std::abs(direction.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 a = glm::normalize(glm::cross(direction, helper));
    return {a, glm::cross(direction, a)};
}

/// Largest divisor of n that is at most its root.
uint32_t columns_of(int n) {
    int columns = 1;
    for (int c = 2; c * c <= n; ++c) {
        if (n % c == 0) columns = c;
    }
    return static_cast<uint32_t>(columns);
}

/// A step through n things that meets them all and leaps far each time.
uint32_t stride_of(uint32_t n) {
    auto stride = static_cast<uint32_t>(0.618 * n) + 1;
    while (std::gcd(stride, n) != 1) ++stride;
    return stride;
}

}  // namespace

Vec3 BlockLight::point_on(const BlockVoxel& voxel, int face, double u, double v) const {
    const int axis = face / 2;
    Vec3 point(block_.corner() + voxel.at);
    if (face % 2 == 0) point[axis] += 1.0;
    point[(axis + 1) % 3] += u;
    point[(axis + 2) % 3] += v;
    return point;
}

bool BlockLight::visible(const Vec3& from, const Vec3& direction) {
    const ShadowResult shadow =
        cast_shadow_ray(source_.tree, {from, direction}, std::numeric_limits<double>::infinity(),
                        source_.params.shadow);
    cost_.steps += shadow.blocker.steps;
    return shadow.visible;
}

void BlockLight::add_sun() {
    const std::vector<BlockVoxel>& voxels = block_.voxels();
    for (size_t i = 0; i < voxels.size() && !source_.cancel.cancelled(); ++i) {
        for (int face = 0; face < kFaceCount; ++face) {
            if (((voxels[i].exposed >> face) & 1u) != 0) {
                irradiance_[i][static_cast<size_t>(face)] += sun_irradiance(voxels[i], face);
            }
        }
    }
}

/// The mean over stratified points of the face and directions of the disc. The radiance of the disc
/// is such that it gives the sun's irradiance to a surface that faces its centre.
Vec3 BlockLight::sun_irradiance(const BlockVoxel& voxel, int face) {
    const Sun& sun = *source_.sun;
    const Vec3 centre = glm::normalize(sun.direction);
    const double radius = sun.angular_diameter_deg * std::numbers::pi / 360.0;
    const Vec3 normal = normal_of(face);
    if (glm::dot(centre, normal) <= -std::sin(radius)) return Vec3(0.0);
    const int n = source_.params.sun_rays;
    const uint32_t columns = columns_of(n);
    const uint32_t rows = static_cast<uint32_t>(n) / columns;
    RandomStream random(random_key({source_.params.seed, static_cast<uint64_t>(Purpose::kSun),
                                    voxel.index, static_cast<uint64_t>(face)}));
    const auto face_pattern = static_cast<uint32_t>(random.next());
    const auto disc_pattern = static_cast<uint32_t>(random.next());
    // Any cell of the face goes with any cell of the disc.
    const auto shift = static_cast<uint32_t>(random.below(static_cast<uint64_t>(n)));
    const std::array<Vec3, 2> sideways = across(centre);
    const double flat = 1.0 - std::cos(radius);
    double sum = 0.0;
    for (uint32_t i = 0; i < static_cast<uint32_t>(n); ++i) {
        const Vec2 on_face = correlated_multi_jitter(i, columns, rows, face_pattern);
        Vec3 direction = centre;
        if (radius > 0.0) {
            const Vec2 on_disc = correlated_multi_jitter((i + shift) % static_cast<uint32_t>(n),
                                                         columns, rows, disc_pattern);
            const double cosine = 1.0 - flat * on_disc.x;
            const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
            const double angle = 2.0 * std::numbers::pi * on_disc.y;
            direction = centre * cosine +
                        (sideways[0] * std::cos(angle) + sideways[1] * std::sin(angle)) * sine;
        }
        const double cosine = glm::dot(direction, normal);
        if (!(cosine > 0.0)) continue;
        ++cost_.sun_rays;
        if (visible(point_on(voxel, face, on_face.x, on_face.y), direction)) sum += cosine;
    }
    return Vec3(sun.irradiance) * (sum / n / (1.0 - flat / 2.0));
}

void BlockLight::add_sky() {
    const std::vector<BlockVoxel>& voxels = block_.voxels();
    const int level = source_.params.gather_level;
    const auto node_of = [&](size_t i) {
        return IVec3(voxels[i].at.x >> level, voxels[i].at.y >> level, voxels[i].at.z >> level);
    };
    for (size_t begin = 0; begin < voxels.size() && !source_.cancel.cancelled();) {
        size_t end = begin + 1;
        while (end < voxels.size() && node_of(end) == node_of(begin)) ++end;
        gather_node(begin, end);
        begin = end;
    }
}

void BlockLight::gather_node(size_t begin, size_t end) {
    const int edge = 1 << source_.params.gather_level;
    const IVec3 corner = block_.voxels()[begin].at / edge * edge;
    regions_.assign(static_cast<size_t>((edge + 2) * (edge + 2) * (edge + 2)), 0);
    region_count_ = 0;
    std::vector<Front> fronts;
    for (int face = 0; face < kFaceCount; ++face) {
        fronts.clear();
        for (size_t i = begin; i < end; ++i) {
            const BlockVoxel& voxel = block_.voxels()[i];
            if (((voxel.exposed >> face) & 1u) == 0) continue;
            fronts.push_back({region_of(beside(voxel.at, face), corner), static_cast<uint32_t>(i)});
        }
        std::stable_sort(fronts.begin(), fronts.end(),
                         [](const Front& a, const Front& b) { return a.region < b.region; });
        for (size_t from = 0; from < fronts.size();) {
            size_t to = from + 1;
            while (to < fronts.size() && fronts[to].region == fronts[from].region) ++to;
            gather(face, std::span(fronts).subspan(from, to - from));
            from = to;
        }
    }
}

void BlockLight::gather(int face, std::span<const Front> fronts) {
    const auto cube_face = static_cast<CubeFace>(face);
    if (source_.sky.irradiance(cube_face) == Vec3(0.0)) return;
    const std::vector<BlockVoxel>& voxels = block_.voxels();
    RandomStream random(random_key({source_.params.seed, static_cast<uint64_t>(Purpose::kSky),
                                    voxels[fronts[0].voxel].index, static_cast<uint64_t>(face)}));
    const auto strata = static_cast<uint32_t>(source_.sky.strata());
    const uint32_t columns = columns_of(source_.sky.strata());
    const auto pattern = static_cast<uint32_t>(random.next());
    const auto shift = static_cast<uint32_t>(random.below(strata));
    const uint32_t stride = stride_of(strata);
    Vec3 sum(0.0);
    for (int s = 0; s < source_.sky.strata(); ++s) {
        const Front& front = fronts[random.below(fronts.size())];
        // Points are stratified like the directions; any goes with any.
        const auto point =
            static_cast<uint32_t>((static_cast<uint64_t>(s) * stride + shift) % strata);
        const Vec2 at = correlated_multi_jitter(point, columns, strata / columns, pattern);
        const Vec3 direction = source_.sky.direction(cube_face, s, random);
        if (visible(point_on(voxels[front.voxel], face, at.x, at.y), direction)) {
            sum += source_.sky.weight(cube_face, s);
        }
    }
    ++cost_.gatherings;
    cost_.sky_rays += static_cast<uint64_t>(source_.sky.strata());
    for (const Front& front : fronts) irradiance_[front.voxel][static_cast<size_t>(face)] += sum;
}

int BlockLight::region_of(const IVec3& front, const IVec3& corner) {
    const int edge = 1 << source_.params.gather_level;
    const int side = edge + 2;
    const auto cell = [&](const IVec3& at) -> int& {
        const IVec3 from = at - corner + IVec3(1);
        return regions_[static_cast<size_t>((from.z * side + from.y) * side + from.x)];
    };
    if (cell(front) != 0) return cell(front);
    cell(front) = ++region_count_;
    open_.assign(1, front);
    while (!open_.empty()) {
        const IVec3 at = open_.back();
        open_.pop_back();
        for (int face = 0; face < kFaceCount; ++face) {
            const IVec3 next = beside(at, face);
            const int along = next[face / 2] - corner[face / 2];
            if (along < -1 || along > edge || block_.solid(next) || cell(next) != 0) continue;
            cell(next) = region_count_;
            open_.push_back(next);
        }
    }
    return region_count_;
}

}  // namespace probebake
