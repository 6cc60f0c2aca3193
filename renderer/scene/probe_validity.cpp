#include "scene/probe_validity.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

#include "objects/object_octree.h"
#include "voxels/trace.h"

namespace probebake {
namespace {

constexpr int kDirections = 64;
constexpr int kSteps = 3;  // to either side, per axis
/// A place to move to has half a voxel of air before a flat wall.
constexpr double kMostClosedIn = 0.25;
/// Of the octree: leaves of a few triangles.
constexpr uint32_t kTrianglesPerLeaf = 8;
constexpr int kDeepestOctree = 10;

/// Spread evenly over the sphere (a spiral of golden angles).
const std::array<Vec3, kDirections>& directions() {
    static const std::array<Vec3, kDirections> kAll = [] {
        std::array<Vec3, kDirections> directions;
        const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
        for (size_t i = 0; i < directions.size(); ++i) {
            const double y = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / kDirections;
            const double r = std::sqrt(1.0 - y * y);
            const double angle = turn * static_cast<double>(i);
            directions[i] = {r * std::cos(angle), y, r * std::sin(angle)};
        }
        return directions;
    }();
    return kAll;
}

/// The nearest voxel's distance, best children first.
class NearestVoxel {
  public:
    NearestVoxel(const VoxelTree& tree, const Vec3& point) : tree_(tree), point_(point) {}

    double distance() {
        if (!tree_.empty()) visit(tree_.node_levels() - 1, 0, IVec3(0));
        return std::sqrt(least2_);
    }

  private:
    double distance2(const IVec3& low, int edge) const {
        const Vec3 nearest = glm::clamp(point_, Vec3(low), Vec3(low) + Vec3(edge));
        const Vec3 gap = point_ - nearest;
        return glm::dot(gap, gap);
    }

    void visit(int k, uint32_t index, const IVec3& corner) {
        const VoxelNode& node = tree_.nodes()[index];
        const int edge = 1 << (2 * k);
        std::array<std::pair<double, uint32_t>, 64> cells;
        size_t count = 0;
        for (uint64_t rest = node.mask; rest != 0; rest &= rest - 1) {
            const auto bit = static_cast<uint32_t>(std::countr_zero(rest));
            const double d2 = distance2(corner + morton_decode(bit) * edge, edge);
            if (d2 < least2_) cells[count++] = {d2, bit};
        }
        std::sort(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(count));
        for (size_t i = 0; i < count && cells[i].first < least2_; ++i) {
            const auto [d2, bit] = cells[i];
            if (k == 0) {
                least2_ = d2;
            } else {
                visit(k - 1, node.first_child + rank_below(node.mask, bit),
                      corner + morton_decode(bit) * edge);
            }
        }
    }

    const VoxelTree& tree_;
    Vec3 point_;
    double least2_ = std::numeric_limits<double>::infinity();
};

/// Share of directions in which a voxel is met within one voxel's edge.
double closed_in_at(const VoxelTree& tree, const Vec3& origin) {
    int near = 0;
    for (const Vec3& direction : directions()) {
        if (trace(tree, {origin, direction}, {}, {.t_max = 1.0})) ++near;
    }
    return static_cast<double>(near) / kDirections;
}

bool is_below_ground(const Scene& scene, const Vec3& position_m) {
    return scene.solid_ground &&
           trace(scene.tree, {scene.to_voxels(position_m), Vec3(0.0, 1.0, 0.0)});
}

}  // namespace

/// The triangles of a scene and their sides, in voxels.
class SurfaceSides {
  public:
    explicit SurfaceSides(const SurfaceTriangles& surface)
        : set_(set_of(surface)),
          octree_(set_, safe_boxes(set_),
                  {.max_depth = depth_for(set_.size()), .most_items = kTrianglesPerLeaf}),
          one_sided_(surface.one_sided) {}
    SurfaceSides(const SurfaceSides&) = delete;
    SurfaceSides& operator=(const SurfaceSides&) = delete;

    /// `most`: what it is to be counted up to; more is more.
    double backface_at(const Vec3& origin, double most = 1.0) const {
        int backs = 0;
        for (const Vec3& direction : directions()) {
            if (backs > most * kDirections) break;
            const ObjectHit hit = octree_.closest_hit({origin, direction});
            if (!hit || hit.object >= one_sided_) continue;
            const Vec3 point = origin + hit.t * direction;
            if (glm::dot(normal_at(set_, hit.object, point), direction) > 0.0) ++backs;
        }
        return static_cast<double>(backs) / kDirections;
    }
    uint64_t memory_bytes() const {
        return octree_.octree().memory_bytes() +
               set_.size() * (sizeof(Triangle) + sizeof(ObjectRef));
    }

  private:
    static ObjectSet set_of(const SurfaceTriangles& surface) {
        ObjectSet set;
        for (const std::array<IVec3, 3>& t : surface.triangles) {
            set.add(Triangle{voxels_of(t[0]), voxels_of(t[1]), voxels_of(t[2])});
        }
        return set;
    }
    /// A surface of n triangles fills some 4^depth leaves.
    static int depth_for(size_t triangles) {
        int depth = 1;
        while ((size_t{1} << (2 * depth)) < triangles && depth < kDeepestOctree) ++depth;
        return depth;
    }

    ObjectSet set_;
    ObjectOctree octree_;
    uint64_t one_sided_;
};

PlaceFinder::PlaceFinder(const Scene& scene, const PlaceRules& rules, bool ask_triangles)
    : scene_(scene), rules_(rules) {
    if (ask_triangles && !scene.surface.empty()) {
        sides_ = std::make_unique<const SurfaceSides>(scene.surface);
    }
}

PlaceFinder::~PlaceFinder() = default;

uint64_t PlaceFinder::octree_bytes() const { return sides_ ? sides_->memory_bytes() : 0; }

bool PlaceFinder::is_valid(const Vec3& position_m, double& closed_in) const {
    if (scene_.inside_voxel(position_m) || is_below_ground(scene_, position_m)) return false;
    const Vec3 at = scene_.to_voxels(position_m);
    closed_in = closed_in_at(scene_.tree, at);
    if (closed_in > rules_.max_closed_in) return false;
    return !sides_ || sides_->backface_at(at, rules_.max_backface) <= rules_.max_backface;
}

ProbePlace PlaceFinder::look_at(const Vec3& position_m) const {
    const Vec3 at = scene_.to_voxels(position_m);
    const bool in_voxel = scene_.inside_voxel(position_m);
    ProbePlace place{.requested_m = position_m,
                     .inside_geometry = in_voxel || is_below_ground(scene_, position_m)};
    place.closed_in = in_voxel ? 1.0 : closed_in_at(scene_.tree, at);
    if (sides_) place.backface = sides_->backface_at(at);
    place.valid = rules_.pass(place);
    place.nearest_surface_m = NearestVoxel(scene_.tree, at).distance() * scene_.voxel_size_m;
    return place;
}

Vec3 PlaceFinder::relocated(const Vec3& position_m, const Vec3& most_offset_m) const {
    double closed_in = 0.0;
    if (is_valid(position_m, closed_in)) return position_m;
    struct Candidate {
        double distance2;
        IVec3 step;  // −kSteps to kSteps
    };
    std::vector<Candidate> candidates;
    for (int z = -kSteps; z <= kSteps; ++z) {
        for (int y = -kSteps; y <= kSteps; ++y) {
            for (int x = -kSteps; x <= kSteps; ++x) {
                const Vec3 offset = Vec3(x, y, z) / double(kSteps) * most_offset_m;
                candidates.push_back({glm::dot(offset, offset), {x, y, z}});
            }
        }
    }
    // In rising z, y, x already.
    std::stable_sort(
        candidates.begin(), candidates.end(),
        [](const Candidate& a, const Candidate& b) { return a.distance2 < b.distance2; });
    std::optional<Vec3> tight;
    for (const Candidate& candidate : candidates) {
        const Vec3 at = position_m + Vec3(candidate.step) / double(kSteps) * most_offset_m;
        if (!is_valid(at, closed_in)) continue;
        if (closed_in <= kMostClosedIn) return at;
        if (!tight) tight = at;
    }
    return tight.value_or(position_m);
}

}  // namespace probebake
